"""What a series follows: chance does not speak, and what is there is named."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.inputs.follower import ALWAYS, DRIVE
from estimator.missing_heat.follows import Series, follows
from estimator.missing_heat.orders import ORDERS

NAMES = ("always", "drive", "speed", "time", "early_stop", "air")
KNOWN = (ALWAYS, *(replace(DRIVE, name=name) for name in NAMES[1:]))
BLOCKS = 15


def shapes(speed: float, dice: np.random.Generator) -> np.ndarray:
    """Followers of a recording with a drive every seven blocks."""
    t = np.arange(BLOCKS)
    drive = (t % 7 == 0).astype(float)
    air = np.cumsum(dice.standard_normal(BLOCKS))
    return np.stack([np.ones(BLOCKS), drive, drive * speed, t / 6, (t % 7 == 1).astype(float), air], axis=1)


def series(dice: np.random.Generator, recordings: int, lasting: float, **signal: float) -> list[Series]:
    """Noise of sd 1 that lasts for some blocks, and a signal."""
    t = np.arange(BLOCKS)
    lower = np.linalg.cholesky(np.exp(-np.abs(t[:, None] - t) / lasting) + 1e-9 * np.eye(BLOCKS))
    found = []
    for r in range(recordings):
        followers = shapes((r + 1) / recordings, dice)
        values = lower @ dice.standard_normal(BLOCKS)
        for name, size in signal.items():
            values = values + size * followers[:, NAMES.index(name)]
        found.append(Series(values, np.full(BLOCKS, 0.1), followers))
    return found


@pytest.mark.parametrize(("recordings", "lasting"), [(1, 3.0), (4, 0.1)], ids=["lasting", "white"])
def test_p_of_noise_is_uniform_or_cautious(recordings, lasting):
    dice = np.random.default_rng(recordings)
    p = np.array([follows(series(dice, recordings, lasting), KNOWN).p for _ in range(80)])
    assert np.mean(p < 0.05) < 0.11
    assert np.mean(p < 0.2) < 0.33
    assert 0.3 < np.median(p) < 0.7


@pytest.mark.parametrize("name", ["drive", "speed", "early_stop", "time"])
def test_a_signal_is_named(name):
    found = follows(series(np.random.default_rng(5), 4, 0.5, **{name: 12.0}), KNOWN)
    assert found.name == name
    assert found.p < 0.01
    assert found.explains > 0.7


def test_rivals_are_those_that_explain_as_much():
    strong = follows(series(np.random.default_rng(5), 4, 0.5, speed=40.0), KNOWN)
    assert strong.rivals == ()
    dice = np.random.default_rng(5)
    alike = [
        replace(each, followers=np.column_stack([each.followers, each.followers[:, 2] + 0.01 * dice.random(BLOCKS)]))
        for each in series(dice, 4, 0.5, speed=12.0)
    ]
    found = follows(alike, (*KNOWN, replace(DRIVE, name="twin")))
    assert {found.name, *(rival.name for rival in found.rivals)} == {"speed", "twin"}


def test_p_counts_the_order_that_there_was_among_the_others():
    """(1 + orders that explain as much) / (1 + orders): never nothing, however clear the signal is."""
    found = follows(series(np.random.default_rng(5), 12, 0.1, speed=40.0), NAMES)
    assert found.p == pytest.approx(1 / (1 + ORDERS), rel=1e-12)


def test_what_does_not_change_is_always_there():
    found = follows(series(np.random.default_rng(6), 4, 0.5, always=8.0), KNOWN)
    assert found.follower is ALWAYS
    assert follows(series(np.random.default_rng(6), 4, 0.5, always=8.0), KNOWN, steady=False).follower is not ALWAYS


def test_one_recording_names_nothing_that_its_order_cannot_tell():
    assert follows(series(np.random.default_rng(7), 1, 0.5, drive=30.0), KNOWN).name is None


def test_the_answer_is_the_same_each_time():
    one, other = (follows(series(np.random.default_rng(8), 3, 1.0, speed=1.0), KNOWN) for _ in range(2))
    assert one == other


def test_too_few_values_and_no_variation_say_nothing():
    few = Series(np.ones(2), np.ones(2), np.ones((2, 6)))
    flat = Series(np.zeros(9), np.ones(9), np.ones((9, 6)))
    assert follows([few], KNOWN).name is None
    assert follows([flat], KNOWN).name is None
