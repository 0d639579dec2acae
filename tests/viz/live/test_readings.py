"""The dial at rest in live views: joined to the drive before it, by readings and the model alone."""

import numpy as np
import pytest

from viz.live.readings import EDGE_S, Dial, Level

SCATTER_UM, DRIFT_UM_S = 0.1, 2e-4
STOP_S, AGAIN_S, REST_S, END_S = 300.0, 900.0, 1100.0, 2000.0


def lived(seed: int) -> dict[float, tuple[float, Level | None]]:
    """What is left in truth and what the dial says of it, by time: rest, two drives and rests, each with its zero."""
    dice, dial, found = np.random.default_rng(seed), Dial(), {}
    for time_s in np.arange(1.0, END_S):
        driving = 60.0 < time_s <= STOP_S or AGAIN_S < time_s <= REST_S
        zero = 7.0 if driving else 30.0 if time_s <= 60.0 else -12.0 if time_s <= AGAIN_S else 4.0
        truth = DRIFT_UM_S * time_s
        reading = truth + zero + dice.normal(0.0, SCATTER_UM)
        found[time_s] = truth, dial.tick(time_s, driving, reading if time_s % 3 else np.nan, 0.0)
    return found


@pytest.fixture(scope="module")
def said() -> list[dict[float, tuple[float, Level | None]]]:
    return [lived(seed) for seed in range(8)]


def test_it_is_told_at_rest_and_not_before_it_is_known(said):
    told = [time_s for time_s, (_, level) in said[0].items() if level]
    for begin_s, end_s in ((1.0, 60.0), (STOP_S + 1, AGAIN_S), (REST_S + 1, END_S - 1)):
        assert set(np.arange(begin_s + EDGE_S, end_s + 1)) <= set(told)
    assert not any(60.0 < time_s <= STOP_S + EDGE_S for time_s in told)


def test_the_zero_of_a_rest_is_that_of_the_drive_before(said):
    """Within what its variance says, on eight runs."""
    for when in (600.0, 850.0, 1400.0, 1900.0):
        apart = np.array([(run[when][1].um - run[when][0]) / np.sqrt(run[when][1].variance) for run in said])
        assert abs(apart.mean()) < 0.8, when
        assert 0.5 < apart.std() < 1.6, when
        assert max(abs(run[when][1].um - run[when][0]) for run in said) < 0.5


def test_what_is_never_read_is_never_told():
    dial = Dial()
    assert not any(dial.tick(time_s, False, np.nan, 0.0) for time_s in np.arange(1.0, 200.0))
