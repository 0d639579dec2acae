"""The model alone: what a reading shows that was taken before the tick's close."""

import numpy as np
import pytest

from estimator.batch.nominal import open_loop
from estimator.inputs.start import Start
from estimator.network.forcing import Forcing
from estimator.state.open_loop import OpenLoop, lag_filter

START_C = 22.0


@pytest.fixture(scope="module", params=["small", "half"])
def run(request, small_model, driven):
    """Forcing and drive of a rig of thermometers that do not lag."""
    rig = request.getfixturevalue(request.param)
    model = small_model.with_values({"thermometers.tau": 0.0})
    forcing = Forcing(model, rig, Start(START_C, 0.0, dict.fromkeys(rig.inputs, 0.0)))
    return forcing, forcing.read(driven(rig, 40, (5, 30), stroke=(0.0, 100.0)))


@pytest.fixture(scope="module")
def spots(run) -> tuple[np.ndarray, np.ndarray]:
    """Times (K + 1,) s from the start on, and what the channels would read then, without offsets (K + 1, m)."""
    forcing, drive = run
    ticks, start = forcing.ticks(drive), np.full(forcing.place.size, START_C)
    states = [start]
    for regime, heat in zip(ticks.regime, ticks.heat, strict=True):
        move = forcing.transition(regime)
        states.append(move.F @ states[-1] + move.J @ heat)
    return np.arange(len(states)) * forcing.rig.tick_s, np.array(states) @ forcing.readings.rows.T


def earlier(spots, ages_s: np.ndarray) -> np.ndarray:
    """What the channels showed so long before the close of each tick, at most a tick back: straight lines between."""
    at_s, values = spots
    before = at_s[1:, None] - np.minimum(ages_s, at_s[1])
    return np.stack([np.interp(t, at_s, column) for t, column in zip(before.T, values.T, strict=True)], axis=1)


@pytest.mark.parametrize("age_s", [0.0, 0.2, 0.45, 3.0])
def test_a_late_reading_is_what_was_there_when_it_was_taken(run, spots, age_s):
    """A tick at a time, and a whole recording at once."""
    forcing, drive = run
    ages_s = age_s * np.linspace(0.5, 1.0, spots[1].shape[1]) * np.ones_like(spots[1][1:])
    ticks, start = forcing.ticks(drive), np.full(forcing.place.size, START_C)
    expected = earlier(spots, ages_s)
    alone, found = OpenLoop(start, forcing.readings, forcing.rig.tick_s), []
    for k, (regime, heat) in enumerate(zip(ticks.regime, ticks.heat, strict=True)):
        alone.step(forcing.transition(regime), heat)
        found.append(alone.reading + alone.late(ages_s[k]))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)
    whole = open_loop(forcing, drive, start, ages_s) - ticks.offset
    np.testing.assert_allclose(whole, expected, rtol=0, atol=1e-9)
    assert (np.abs(expected - spots[1][1:]).max() > 1e-3) == (age_s > 0)


def test_a_lag_shows_where_there_is_none_yet():
    """A reading without a lag moves with one as the spot rises: by -dT/dt, a tick's change over its length."""
    keep, ramp = lag_filter(np.array([0.0 + 1e-20j]), 4.0)
    assert (keep[0], ramp[0].real) == (0.0, pytest.approx(1.0))
    assert ramp[0].imag / 1e-20 == pytest.approx(-1.0 / 4.0)
