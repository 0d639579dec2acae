"""What a channel's innovation is compared with, learnt tick by tick."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.faults.fault import Led, Seen
from estimator.faults.jumps import Jumps

TICKS, CHANNELS = 30, 4
FINE = np.zeros(CHANNELS)  # a resolution


def seen(value: np.ndarray) -> Seen:
    """Innovations (K, m) of thermometers at 22 degC, that the model alone stays at."""
    alone, none = np.full(value.shape, 22.0), np.zeros(value.shape, dtype=bool)
    time_s, doubt = np.arange(len(value)) + 1.0, np.zeros((*value.shape, 0))
    sd, never = np.full(value.shape, 0.03), np.zeros(len(value), dtype=bool)
    return Seen(time_s, alone + value, value, sd, alone, none, doubt, Led.nowhere(len(value), 0), never, never)


def test_a_model_that_stays_where_it_began_has_not_moved_and_all_at_once_is_tick_by_tick():
    """Or a jump in the first minute would be within its limit."""
    value = 0.02 * np.random.default_rng(0).standard_normal((TICKS, CHANNELS))
    heat, well = np.ones(CHANNELS, dtype=bool), np.ones(CHANNELS, dtype=bool)
    whole, apart = (Jumps(np.full(CHANNELS, 0.02), heat, 1.0, 100.0 * np.arange(CHANNELS)) for _ in range(2))
    together = whole.compare(seen(value), well, ~well, FINE)
    assert (together.limit[10:] < 0.3).all()
    for k in range(TICKS):
        one = apart.compare(seen(value[k : k + 1]), well, ~well, FINE)
        np.testing.assert_allclose(one.limit[0], together.limit[k], rtol=1e-12)
        apart.learn(one, 1, well)


@pytest.mark.parametrize(
    ("off_K", "beside_K", "beyond"), [(0.15, 0.0, False), (1.0, 0.1, True), (1.0, 0.4, False), (3.0, 2.0, True)]
)
def test_after_a_silence_one_is_off_as_far_as_the_next_one_shows_of_it(off_K, beside_K, beyond):
    """After ten minutes: by 2 K at most, of which the next one shows a third; 0.3 K are within the model's sd."""
    heat = well = np.ones(CHANNELS, dtype=bool)
    jumps = Jumps(np.full(CHANNELS, 0.02), heat, 1.0, np.array([300.0, 0.0, 100.0, 200.0]))
    jumps.learn(jumps.compare(seen(np.zeros((TICKS, CHANNELS))), well, ~well, FINE), TICKS, well)
    jumps.forget(heat)  # as the judge does of what was silent
    after = seen(np.array([[off_K, 0.0, 0.0, beside_K]]))
    found = jumps.compare(replace(after, time_s=np.array([TICKS + 600.0])), well, ~well, FINE)
    assert found.beyond[0].tolist() == [beyond, False, False, False]


def test_one_step_of_a_coarse_sensor_is_no_jump():
    """What the model says moves by a millikelvin a tick, what is read by nothing, and then by a step."""
    value = np.zeros((60, CHANNELS)) - 1e-3 * np.arange(60)[:, None] % 0.01
    value[-1] += 0.0625
    heat = well = np.ones(CHANNELS, dtype=bool)
    told = [Jumps(np.full(CHANNELS, 0.01), heat, 1.0, 100.0 * np.arange(CHANNELS)) for _ in range(2)]
    fine, coarse = (one.compare(seen(value), well, ~well, step) for one, step in zip(told, (FINE, FINE + 0.0625)))
    assert fine.beyond[-1].all()
    assert not coarse.beyond.any()
