"""Inputs: gaps are held, temperatures of a steady rig zeroed, and pieces are the whole."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.errors import SetupError
from estimator.inputs.inputs import InputReader, no_inputs
from estimator.inputs.start import Start, read_start
from estimator.network.forcing import Forcing

NAN = np.nan


@pytest.fixture
def run(small, driven):
    """Eight ticks: air read from the third on with a gap, probe never, position with a gap."""
    drive = driven(small, 8, (2, 6), stroke=(0.0, 100.0))
    ambient = np.array([NAN, NAN, 21.0, 21.5, NAN, NAN, 21.75, NAN])
    inputs = {**drive.inputs, "ambient": ambient, "probe": np.full(8, NAN)}
    inputs["position"] = np.array([NAN, 40.0, 50, NAN, 60, 70, 80, 90])
    return replace(drive, inputs=inputs)


@pytest.fixture
def start():
    return Start(22.0, 0.0, {"ambient": -1.0, "probe": 0.0, "nut": 0.5, "bar": 0.0, "board": 0.0, "position": 0.0})


def test_gaps_hold_the_last_value_and_nothing_has_risen_before(small, run, start):
    u = InputReader(small, start).read(run)
    np.testing.assert_array_equal(u["ambient"][:, 0], [22, 22, 22, 22.5, 22.5, 22.5, 22.75, 22.75])  # zeroed by -1 K
    np.testing.assert_array_equal(u.rise("ambient")[:, 0], [0, 0, 0, 0.5, 0.5, 0.5, 0.75, 0.75])
    np.testing.assert_array_equal(u["position"][:, 0], [0, 40, 50, 50, 60, 70, 80, 90])
    assert (u["probe"] == 22).all()
    assert (u.rise("probe") == 0).all()
    assert (u["nut"] == 21.5).all()
    assert (u.rise("no such input") == 0).all()
    assert ("bar" in u, "no such input" in u, len(u)) == (True, False, 8)


def test_a_silent_drive_stands_still_where_the_nut_was(small, run, start):
    silent = replace(run, omega=run.omega.copy(), coverage=run.coverage.copy())
    silent.omega[4] = NAN
    silent.coverage[5] = NAN
    u = InputReader(small, start).read(silent)
    np.testing.assert_array_equal(u.omega[:, 0], [0, 0, *run.omega[2:4], 0, run.omega[5], 0, 0])
    np.testing.assert_array_equal(u.coverage[[4, 5]], run.coverage[[3, 3]])
    np.testing.assert_array_equal(np.delete(u.coverage, [4, 5], 0), np.delete(run.coverage, [4, 5], 0))


@pytest.mark.parametrize("cut", [1, 3, 5])
def test_pieces_are_the_whole(small, run, start, cut):
    run.omega[3] = NAN
    run.coverage[5] = NAN
    whole, reader = InputReader(small, start).read(run), InputReader(small, start)
    pieces = [reader.read(run.rows(slice(k, min(k + cut, 8)))) for k in range(0, 8, cut)]
    for name in small.inputs:
        np.testing.assert_array_equal(np.vstack([u[name] for u in pieces]), whole[name])
        np.testing.assert_array_equal(np.vstack([u.rise(name) for u in pieces]), whole.rise(name))
    np.testing.assert_array_equal(np.vstack([u.coverage for u in pieces]), whole.coverage)
    np.testing.assert_array_equal(np.vstack([u.omega for u in pieces]), whole.omega)


def test_an_unknown_input_names_what_was_meant(small, run, start):
    with pytest.raises(SetupError, match=r"^needs the input 'ambiant', .* did you mean 'ambient'\?"):
        InputReader(small, start).read(run)["ambiant"]


def first(small, driven, channels, omega=0.0, **inputs):
    sample = driven(small, 1).sample(0)
    return replace(sample, channels=np.array(channels), omega=omega, inputs={**sample.inputs, **inputs})


def test_a_steady_rig_zeroes_the_temperatures_near_it(small, driven):
    found = read_start(first(small, driven, [22, 22.1, 22.05, NAN, 7], ambient=21.05, nut=24.0, bar=NAN), small)
    assert (found.level_C, found.spread_K) == pytest.approx((22.05, 0.1))
    expected = {"ambient": -1.0, "nut": 0.0, "probe": -0.05, "bar": 0.0, "board": -0.05, "position": 0.0}
    assert found.zero_K == pytest.approx(expected)


@pytest.mark.parametrize("odd", [62.0, -40.0, 23.4, 20.6])
def test_an_odd_thermometer_does_not_make_a_steady_rig_warm(odd, small, driven):
    """Beside 22.0, 22.1 and 22.02 degC: a spike, or one wrong by more than a kelvin."""
    found = read_start(first(small, driven, [22.0, 22.1, odd, 22.02, NAN], ambient=21.0), small)
    assert found.level_C == pytest.approx(22.02, abs=0.05)
    counted = [22.0, 22.1, odd] if abs(odd - 22) < 10 else [22.0, 22.1]
    assert found.spread_K == pytest.approx(max(counted) - min(counted))
    assert found.zero_K["ambient"] == pytest.approx(21.0 - found.level_C)


def test_two_that_are_26_K_apart_are_both_odd_and_the_start_as_unknown(small, driven):
    found = read_start(first(small, driven, [9.0, 35.0, NAN, NAN, NAN]), small)
    assert (found.level_C, found.spread_K) == (22.0, 26.0)


def test_a_warm_rig_s_own_spread_is_not_odd(small, driven):
    """Where all differ, none is odd: 4 K at one end beside half a kelvin around the middle."""
    found = read_start(first(small, driven, [22.0, 22.8, 23.4, 26.0, NAN]), small)
    assert (found.level_C, found.spread_K) == pytest.approx((23.1, 4.0))


def test_muted_thermometers_have_no_say_in_the_start(small, driven):
    sample = first(small, driven, [22, 22.1, 100, 100, 7.0])
    found = read_start(sample, small, np.array([False, False, True, True, False]))
    assert (found.level_C, found.spread_K) == pytest.approx((22.05, 0.1))
    assert read_start(sample, small, np.array([True, True, True, True, False])) is None


@pytest.mark.parametrize(("channels", "omega"), [([22, 22.5, 22.5, 22, NAN], 0.0), ([22, 22, 22, 22, NAN], 50.0)])
def test_a_warm_or_turning_rig_is_taken_as_it_is(small, driven, channels, omega):
    found = read_start(first(small, driven, channels, omega, ambient=21.0), small)
    assert set(found.zero_K.values()) == {0.0}
    assert found.above_K == pytest.approx(found.level_C - 21.0)


@pytest.mark.parametrize(("ambient", "above_K"), [(20.5, 2.5), (24.0, 0.0), (0.0, 0.0), (NAN, 0.0)])
def test_a_warm_screw_is_above_the_air_as_far_as_that_is_credible(small, driven, ambient, above_K):
    warm = read_start(first(small, driven, [22, 23, 23, 24, NAN], ambient=ambient), small)
    assert warm.above_K == pytest.approx(above_K)
    assert read_start(first(small, driven, [23, 23, 23, 23, NAN], ambient=ambient), small).above_K == 0.0


def test_between_steady_and_warm_it_is_partly_zeroed(small, driven):
    """A hundredth of a kelvin must not decide: recordings read at another tick would begin elsewhere."""
    zeros = [
        read_start(first(small, driven, [22, 22 + apart, 22 + apart, 22, NAN], ambient=21.0), small).zero_K["ambient"]
        for apart in (0.09, 0.11, 0.15, 0.19, 0.21)
    ]
    shares = np.array(zeros) / (21.0 - 22.0 - np.array([0.09, 0.11, 0.15, 0.19, 0.21]) / 2)
    np.testing.assert_allclose(shares, [1.0, 0.9, 0.5, 0.1, 0.0], atol=1e-9)


def test_without_a_thermometer_there_is_no_start(small, driven):
    assert read_start(first(small, driven, [NAN, NAN, NAN, NAN, 7.0]), small) is None


def test_what_conducts_goes_by_time_and_by_how_unevenly_it_turns(small, small_model, driven):
    """A third of each tick the nut waits at the left: friction heats where it turns, contact goes by time."""
    run = driven(small, 80, (10, 70))
    turns, waits = (small.screw.overlap(at, at + small.nut.length_mm) for at in (60.0, 0.0))
    moving, stay = run.omega > 0, np.where((run.omega > 0)[:, None], turns * 2 / 3 + waits / 3, waits)
    run = replace(
        run, coverage=np.where(moving[:, None], turns, waits), stay=stay, unevenness=np.full(80, 1.5), idle=moving / 3.0
    )
    forcing = Forcing(small_model, small, Start(22.0, 0.0, dict.fromkeys(small.inputs, 0.0)))
    drive = forcing.read(run)
    u = forcing.regime_inputs()
    (fast,) = set(drive.regime[20:60])
    np.testing.assert_allclose(u.coverage[fast], stay[30], atol=1e-12)
    np.testing.assert_array_equal(drive.inputs.coverage[30], turns)
    full = run.omega[30] * 1.5 / (small.screw.reference_rpm * 2 * np.pi / 60)  # the speed while it turns
    assert u.air_law(small.screw, 0.0)[fast, 0] == pytest.approx(2 / 3)
    assert u.air_law(small.screw, 0.67)[fast, 0] == pytest.approx(2 / 3 * full**0.67)


@pytest.mark.parametrize(("ramps", "idle"), [(0.24, 0.0), (0.66, 0.0), (0.5, 0.33), (0.0, 0.5)])
@pytest.mark.parametrize("n", [0.5, 0.7, 0.9])
def test_what_grows_less_than_in_proportion_to_speed_hears_of_waits(ramps, idle, n, rig):
    """Mean of w^n over a stroke with ramps and a wait: from mean speed alone up to 23 % too high."""
    speed = np.concatenate([np.full(6000, 100.0), np.linspace(0.0, 100.0, 6000)])
    weight = (1.0 - idle) * np.repeat([1.0 - ramps, ramps], 6000) / 6000
    mean, square = weight @ speed, weight @ speed**2
    u = no_inputs(rig, np.array([[mean]]), np.zeros((1, rig.screw.cells)), square / mean**2, np.array([[idle]]))
    true = weight @ rig.screw.relative_speed(speed) ** n
    assert u.air_law(rig.screw, n)[0, 0] == pytest.approx(true, rel=0.012)


@pytest.mark.parametrize("ramps", [0.0, 0.24, 0.66])
@pytest.mark.parametrize("n", [1.0, 1.2, 1.39, 2.0])
def test_a_speed_law_holds_for_uneven_motion(ramps, n, rig):
    """Mean of w^n over a stroke that is ramps for a part of it, from its mean speed and unevenness alone."""
    end = 0.0 if ramps else 1.0
    speed = np.interp(np.linspace(0, 1, 100_001), [0, ramps / 2, 1 - ramps / 2, 1], [end, 1, 1, end])
    mean, square = speed.mean(), (speed**2).mean()
    reference = rig.screw.reference_rpm * 2 * np.pi / 60
    u = replace(
        no_inputs(rig, np.array([[mean * reference]]), np.zeros((1, rig.screw.cells))),
        unevenness=np.array([[square / mean**2]]),
    )
    true = (speed**n).mean()
    assert u.speed_law(rig.screw, n)[0, 0] == pytest.approx(true, rel=1e-4 if n in (1.0, 2.0) else 0.015)
    if ramps == 0.66:
        assert abs(mean**n - true) > abs(u.speed_law(rig.screw, n)[0, 0] - true) or n == 1.0
