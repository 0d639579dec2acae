"""What motion leaves behind: pieces are the whole, and freshness is the solution of its equation."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from estimator.inputs import motion
from estimator.inputs.motion import LEAST_K, POWER_W, STEP, STILL, TURNING, Motion, MotionReader
from estimator.screw import Screw

COLUMNS = ("time_s", "turning", "since_s", "moved", "warmth")
FAST = 100.0
BAR = Screw(0, 1000, 40, 17, reference_rpm=FAST * 30 / np.pi)
STRETCHES = st.lists(st.tuples(st.booleans(), st.integers(1, 40)), min_size=1, max_size=12)
TICKS = st.sampled_from([0.5, 1.0, 5.0])


def speeds(stretches) -> np.ndarray:
    return np.concatenate([np.full(ticks, FAST * turns) for turns, ticks in stretches])


@given(stretches=STRETCHES, cuts=st.lists(st.integers(1, 30), min_size=1, max_size=40), tick_s=TICKS)
def test_pieces_are_the_whole(stretches, cuts, tick_s):
    omega = speeds(stretches)
    whole, reader, pieces = MotionReader(tick_s, BAR).read(omega), MotionReader(tick_s, BAR), []
    begin = 0
    for cut in [*cuts, len(omega)]:
        if begin < len(omega):
            pieces.append(reader.read(omega[begin : begin + cut]))
            begin += cut
    for name in COLUMNS:
        np.testing.assert_array_equal(np.vstack([getattr(piece, name) for piece in pieces]), getattr(whole, name))
    fresh = np.vstack([piece.freshness(30.0, 70.0) for piece in pieces])
    np.testing.assert_allclose(fresh, whole.freshness(30.0, 70.0), rtol=0, atol=1e-12)
    ends = np.cumsum([len(piece.time_s) for piece in pieces])
    for piece, end in zip(pieces, ends, strict=True):
        part = whole.rows(slice(end - len(piece.time_s), end))
        for name in COLUMNS:
            np.testing.assert_array_equal(getattr(part, name), getattr(piece, name))
        np.testing.assert_allclose(part.freshness(30.0, 70.0), piece.freshness(30.0, 70.0), rtol=0, atol=1e-12)


def test_motion_warms_the_screw_as_heat_and_air_do():
    """At first by its power alone, at last until the air takes as much; at rest an hour takes half."""
    surface = np.pi * 0.04
    store = BAR.density * BAR.heat_capacity * BAR.area
    driven = MotionReader(5.0, BAR).read(np.full(4000, FAST)).warmth[:, 0]
    assert driven[0] == pytest.approx(5.0 * POWER_W / store, rel=1e-3)
    assert driven[-1] == pytest.approx(POWER_W / ((STILL + TURNING) * surface), rel=0.01)
    reader = MotionReader(1.0, BAR)
    warm = reader.read(np.full(300, FAST)).warmth[-1, 0]
    cooled = reader.read(np.zeros(3600)).warmth[-1, 0]
    assert cooled / warm == pytest.approx(np.exp(-3600 * STILL * surface / store), rel=1e-6)


def test_a_screw_at_rest_is_taken_for_as_warm_as_it_is_within_a_quarter():
    reader = MotionReader(1.0, BAR, above_K=6.0)
    cooling = reader.read(np.zeros(7200))
    assert cooling.warmth[0] == pytest.approx(6.0, rel=1e-3)
    warm = cooling.warmth[:, 0] > LEAST_K
    assert np.abs(np.log(cooling.rest_K / cooling.warmth)[warm]).max() <= np.log(STEP) / 2 + 1e-9
    assert 4 <= len(np.unique(cooling.rest_K)) <= 7
    assert not reader.read(np.full(9, FAST)).rest_K.any()


@settings(max_examples=30)
@given(stretches=STRETCHES, decay=st.floats(5.0, 900.0), recovery=st.floats(5.0, 900.0), tick_s=TICKS)
def test_freshness_solves_its_equation(stretches, decay, recovery, tick_s):
    """df/dt = -f / decay while turning, (1 - f) / recovery at rest: trapezoids of a hundredth of a tick."""
    omega = speeds(stretches)
    found = MotionReader(tick_s).read(omega).freshness(decay, recovery)
    f, dt, true = 1.0, tick_s / 100, []
    for speed in omega:
        rate, target = (1 / decay, 0.0) if speed else (1 / recovery, 1.0)
        for _ in range(100):
            f += (target - f) * rate * dt / (1 + rate * dt / 2)
        true.append(f)
    np.testing.assert_allclose(found[:, 0], true, rtol=0, atol=1e-5)


@given(stretches=STRETCHES, tick_s=TICKS)
def test_the_columns_say_what_they_are_called(stretches, tick_s):
    omega = speeds(stretches)
    found = MotionReader(tick_s).read(omega)
    since, moved = 0, False
    for k, speed in enumerate(omega):
        since = since + 1 if k and (omega[k - 1] > 0) == (speed > 0) else 1
        moved = moved or speed > 0
        expected = [k * tick_s, float(speed > 0), since * tick_s, float(moved)]
        assert [getattr(found, name)[k, 0] for name in COLUMNS[:4]] == pytest.approx(expected)


@pytest.mark.parametrize("before", [(), ((True, 700.0), (False, 40.0))])
@pytest.mark.parametrize("along", [(1.0, 0.0), (0.0, 1.0)], ids=["decay", "recovery"])
def test_freshness_has_its_slope_by_complex_step(before, along):
    made = replace(MotionReader(1.0).read(speeds([(True, 20), (False, 30), (True, 9)])), before=before)

    def at(step):
        return made.freshness(600 + step * along[0], 900 + step * along[1])

    difference = (at(0.1) - at(-0.1)) / 0.2
    assert abs(difference).max() > 0
    np.testing.assert_allclose(at(1e-30j).imag / 1e-30, difference, rtol=1e-5, atol=1e-12)


def test_nothing_has_happened_at_the_first_instant():
    none = Motion.none(3)
    assert all((getattr(none, name) == 0).all() for name in COLUMNS)
    assert (none.freshness(600.0, 900.0) == 1).all()


def test_what_lay_further_back_than_is_remembered_has_faded(monkeypatch):
    """A screw that starts and stops all day: as fresh, within a thousandth, as one whose every stop is remembered."""
    omega = speeds([(True, 10), (False, 10)] * 300)
    reader = MotionReader(1.0)
    reader.read(omega)
    short = reader.read(omega[:20]).freshness(600.0, 900.0)
    monkeypatch.setattr(motion, "REMEMBERED", 10**6)
    reader = MotionReader(1.0)
    reader.read(omega)
    np.testing.assert_allclose(short, reader.read(omega[:20]).freshness(600.0, 900.0), atol=1e-3)
