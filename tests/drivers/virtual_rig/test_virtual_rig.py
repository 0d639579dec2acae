"""The rig in software shows what is known of the real one, and its sensors err as the real ones do."""

import ast
import math
from pathlib import Path

import numpy as np
import pytest

from drivers.virtual_rig import EXPERIMENTS, Run, simulate
from drivers.virtual_rig.machine import screw
from drivers.virtual_rig.machine.geometry import ANCHOR_BEARING_MM, CHANNEL_MM, SPAN_MM
from drivers.virtual_rig.machine.planted import BASE, PLANTED
from drivers.virtual_rig.population.constants import PAPER
from drivers.virtual_rig.sensors.probes import HOLD_ERROR_UM, NOISE_UM, Gauge, probes
from drivers.virtual_rig.sensors.telemeter import lagging, telemeter

PATTERNS, SPEEDS = ("FS", "CS", "ES"), ("20", "10", "2.5")
BASE_RIG = dict.fromkeys(BASE, 1.0) | dict.fromkeys(PLANTED, 0.0)
NO_EFFECT = dict.fromkeys(BASE_RIG, 0.0)


@pytest.fixture(scope="module")
def drives() -> dict[str, Run]:
    """The first drive of each pattern at the highest, a middle and the lowest speed."""
    return {f"{pattern}-{v}": simulate(f"{pattern}-{v}", cycles=1, stop_s=60.0) for pattern in PATTERNS for v in SPEEDS}


@pytest.fixture(scope="module")
def fs20() -> Run:
    """FS-20 with both drives and both stops."""
    return simulate("FS-20")


def seconds_of_drive(run: Run, number: int = 0) -> float:
    """How long a drive lasted, s"""
    return run.travel.drives[number].stop_s - run.travel.drives[number].start_s


def rise_at(run: Run, t: float) -> dict[int, float]:
    """True rise of each channel by its number at the tick after t, K"""
    return dict(enumerate(run.truth.rises[math.ceil(t)].tolist(), start=1))


def polyline(rises: np.ndarray) -> np.ndarray:
    """12e-6 * area under the straight lines through the channels, over the measured span, um: (n,)"""
    x = np.concatenate([[SPAN_MM[0]], CHANNEL_MM[1:]])
    weights = [np.trapezoid(np.interp(x, CHANNEL_MM, one), x) for one in np.eye(CHANNEL_MM.size)]
    return 12e-3 * rises @ np.array(weights)


def polyline_band(runs: dict[str, Run]) -> tuple[float, float]:
    errors = np.concatenate([run.truth.elongation_um - polyline(run.truth.rises) for run in runs.values()])
    return float(errors.min()), float(errors.max())


def test_fs20_first_reaches_its_maximum_at_222_s(drives):
    assert seconds_of_drive(drives["FS-20"]) == pytest.approx(222.0, rel=0.10)


def test_every_experiment_reaches_50_um_within_two_hours(drives):
    for run in drives.values():
        assert seconds_of_drive(run) < 7200.0
        assert run.truth.elongation_um.max() == pytest.approx(50.0, abs=1.0)


def test_drives_last_longer_at_lower_speed_and_shorter_strokes(drives):
    for pattern in PATTERNS:
        lasting = [seconds_of_drive(drives[f"{pattern}-{speed}"]) for speed in SPEEDS]
        assert lasting == sorted(lasting)
    for speed in SPEEDS:
        full, centre, end = (seconds_of_drive(drives[f"{pattern}-{speed}"]) for pattern in PATTERNS)
        assert full < centre
        assert full < end


def test_second_drive_starts_from_a_warm_screw(fs20):
    assert 0.4 < seconds_of_drive(fs20, 1) / seconds_of_drive(fs20, 0) < 0.8


def test_bearings_stand_out_at_the_first_maximum(fs20):
    rise = rise_at(fs20, fs20.travel.drives[0].stop_s)
    assert rise[12] > max(rise[8], rise[9], rise[15])
    assert rise[2] > max(rise[1], rise[3])


def test_cooldown_turns_the_profile_over(fs20):
    rise = rise_at(fs20, fs20.travel.drives[0].stop_s + 1200.0)
    assert min(rise[4], rise[5], rise[6]) > rise[12]


def test_cs_warms_5_and_6_alike_and_es_warms_5_first(drives):
    for speed in SPEEDS:
        central, eccentric = drives[f"CS-{speed}"], drives[f"ES-{speed}"]
        for share in (0.3, 1.0):
            rise = rise_at(central, 20.0 + share * seconds_of_drive(central))
            assert rise[5] == pytest.approx(rise[6], rel=0.05)
            rise = rise_at(eccentric, 20.0 + share * seconds_of_drive(eccentric))
            assert rise[5] > 1.3 * max(rise[4], rise[6])


def test_polyline_misses_the_shape_between_channels_by_micrometres(drives):
    low, high = polyline_band(drives)
    assert 2.0 < high - low < 6.0


@pytest.mark.study
def test_whole_protocol_of_all_twelve():
    runs = {name: simulate(name) for name in EXPERIMENTS}
    low, high = polyline_band(runs)
    assert 2.0 < high - low < 6.0
    for run in runs.values():
        assert 0.4 < seconds_of_drive(run, 1) / seconds_of_drive(run, 0) < 0.8
        rise = rise_at(run, run.travel.drives[0].stop_s + 1200.0)
        assert min(rise[4], rise[5]) > rise[12]


def test_starts_in_equilibrium_and_rests_before_the_drive(fs20):
    assert fs20.travel.drives[0].start_s == 20.0
    at_rest = fs20.measured.channels[:20].mean(axis=0)
    assert np.ptp(at_rest) < 0.06
    assert np.abs(fs20.truth.rises[:20]).max() < 0.01


def test_ambient_and_base_wander_by_tenths_of_a_kelvin(fs20):
    assert 0.02 < np.ptp(fs20.truth.environment.ambient) < 0.5
    assert 0.01 < np.ptp(fs20.truth.environment.base) < 0.3


def test_elongation_is_the_integral_of_the_mean_rise():
    rise = np.random.default_rng(1).random(screw.CELLS)
    motor = screw.growth_weights(ANCHOR_BEARING_MM, SPAN_MM[1], PAPER.screw.expansion) @ rise
    free = screw.growth_weights(SPAN_MM[0], ANCHOR_BEARING_MM, PAPER.screw.expansion) @ rise
    assert motor + free == pytest.approx(12.0 * (screw.overlap(*SPAN_MM) @ rise) * screw.CELL_M, rel=1e-12)


def test_held_readings_are_true_to_their_own_instant(fs20):
    centres = fs20.holds.centre_s
    assert np.abs(fs20.motion(centres).position_mm - 200.0).max() < 1e-6
    truth = np.interp(centres, fs20.truth.time_s, fs20.truth.elongation_um)
    error = fs20.holds.reading.elongation_um - truth
    first_drive = centres < fs20.travel.drives[0].stop_s
    assert np.ptp(error[first_drive]) < HOLD_ERROR_UM + 8 * NOISE_UM + 0.4
    assert np.all((fs20.holds.frozen_s > centres) & (fs20.holds.frozen_s < centres + 0.1))


def test_direct_reading_joins_the_truth_at_rest_and_wobbles_while_turning(fs20):
    error = fs20.measured.direct.elongation_um - fs20.truth.elongation_um
    stop = math.ceil(fs20.travel.drives[0].stop_s)
    assert np.std(error[:20]) < 2 * NOISE_UM
    assert np.std(error[30:stop]) > 2 * np.std(error[stop : stop + 60])


def test_readings_beyond_the_probes_range_say_so():
    unit = probes(1, NO_EFFECT, PAPER.sensors)
    zero = np.zeros(3)
    reading = unit.held(Gauge(zero, np.array([-5.0, 20.0, 60.0]), zero, zero, zero), np.random.default_rng(0))
    assert reading.state.tolist() == [1, 0, 2]
    assert reading.a2b2.tolist() == [0.0, 42.0, 100.0]


def test_channels_are_the_same_sensors_in_every_run_of_a_seed():
    one, other = (telemeter(seed, BASE_RIG, PAPER.sensors) for seed in (1, 2))
    assert np.array_equal(one.offset, telemeter(1, BASE_RIG, PAPER.sensors).offset)
    assert not np.array_equal(one.offset, other.offset)
    assert np.abs(one.offset).max() <= 0.025
    assert one.lag_s.mean() == pytest.approx(8.0, abs=1.5)


def test_thermometers_read_in_steps_of_a_hundredth(fs20):
    shown = fs20.measured.channels / 0.01
    assert np.abs(shown - np.round(shown)).max() < 1e-6
    lag = fs20.measured.channels[120] - fs20.truth.channels[120]
    assert lag[4] < -0.1


def test_lag_of_a_ramp_is_its_slope_times_the_time_constant():
    ramp = 20.0 + 0.05 * np.arange(200.0)
    assert lagging(ramp, 8.0)[-1] == pytest.approx(ramp[-1] - 0.05 * 8.0)
    assert lagging(ramp, 8.0)[0] == ramp[0]


def test_same_seed_same_run_and_other_seed_another():
    one, again, other = (simulate("CS-10", seed=seed, seconds=40.0) for seed in (3, 3, 4))
    assert np.array_equal(one.measured.channels, again.measured.channels)
    assert np.array_equal(one.holds.reading.a2b2, again.holds.reading.a2b2)
    assert not np.array_equal(one.measured.channels, other.measured.channels)


def test_seconds_cut_a_run_and_other_speeds_are_allowed():
    run = simulate("CS-7.5", seconds=45.0)
    assert run.measured.time_s[-1] == 45.0
    assert np.abs(run.drive(np.arange(20.0, 45.0, 0.01)).speed_rpm).max() == pytest.approx(625.0)


def test_the_longest_drive_ends_with_its_stroke():
    run = simulate("ES-20", cycles=1, max_drive_s=30.0, stop_s=10.0)
    (drive,) = run.travel.drives
    assert 30.0 <= seconds_of_drive(run) < 30.0 + 2 * drive.stroke.duration_s
    assert run.motion(np.array([drive.stop_s])).position_mm[0] in (202.0, 315.0)


def test_progress_is_told_each_minute():
    told = []
    simulate("FS-20", seconds=130.0, progress=lambda t, elongation: told.append((t, elongation)))
    assert [t for t, _ in told] == [60.0, 120.0]
    assert told[1][1] > told[0][1] > 0.0


def test_shares_no_code_with_the_estimator():
    for source in Path(screw.__file__).parents[1].rglob("*.py"):
        for node in ast.walk(ast.parse(source.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert all(name.partition(".")[0] not in ("estimator", "viz", "ballscrew") for name in names), source.name
