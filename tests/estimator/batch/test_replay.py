"""The replay of a whole recording gives the numbers of the filter that takes it a tick at a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.recordings import read_recording
from estimator import filter as filtering
from estimator.batch import replay as module
from estimator.batch.replay import Replay, replay
from estimator.effect import Effect, Param
from estimator.effects.readings import Thermometers
from estimator.faults.fault import Fault
from estimator.faults.judge import START_S, TOGETHER_TICKS
from estimator.faults.suspects import HELD_S
from estimator.filter import Filter
from estimator.model import Model, model_of
from estimator.network import regime
from estimator.record import Recording
from estimator.rig import Channel, Rig, Signal
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.step import SERIES, Mode, Track
from estimator.terms import Heat, Link, Store
from tests.conftest import stepped

ROOT = Path(__file__).parents[3]
PAPER, ROD = ROOT / "recordings", ROOT / "examples" / "heated_rod"
TICKS = 150
SPIKE_K = 30.0


def both(model, rig, recording, mute=None) -> Track:
    """The filter's track, after every field of the replay has been found equal to it."""
    slow, fast = stepped(Filter(model, rig, mute), recording), replay(model, rig, recording, mute)
    assert (fast.bodies, fast.names) == (slow.bodies, slow.names)
    np.testing.assert_array_equal(fast.x_mm, slow.x_mm)
    for key in SERIES:
        a, b = getattr(fast, key), getattr(slow, key)
        assert a.shape == b.shape, key
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9, err_msg=key)
    return slow


def lived_on(rig: Rig, model: Model, stroke_mm: float, driven, live) -> tuple[Model, Rig, Recording]:
    """A recording with noise: a drive and some rest, air and board that warm up."""
    spans = np.array([TICKS, 20, 90]) * rig.tick_s
    drive = driven(rig, spans[0], tuple(spans[1:]), stroke=(0.0, stroke_mm))
    for name in ("ambient", "board"):
        drive.inputs[name][:] = 22 + np.linspace(0, 3, TICKS)
    return model, rig, live(model, rig, drive, seed=1, process=True).recording


@pytest.fixture(scope="module")
def lived(half, small_model, driven, live) -> tuple[Model, Rig, Recording]:
    """On the small rig at two ticks a second; the judge at one a second, on the paper's rig: faults/test_judge.py."""
    return lived_on(half, small_model, 100.0, driven, live)


@pytest.fixture(scope="module", params=["half", "rig"])
def anywhere(request, driven, live) -> tuple[Model, Rig, Recording]:
    """The same, and on the paper's rig."""
    if request.param == "half":
        return request.getfixturevalue("lived")
    rig, full = (request.getfixturevalue(name) for name in ("rig", "full"))
    return lived_on(rig, full, 400.0, driven, live)


def test_counted_from_a_zero_only_lengths_are_others(anywhere):
    """By what by now is known to have been grown at the first sample, another coefficient included."""
    model, rig, recording = anywhere
    counted, filter_ = both(model, replace(rig, zero_C=20.0, zero_sd_K=0.1), recording), Filter(model, rig)
    usual = stepped(filter_, recording)
    lengths = {"elongation_um", "sigma_um", "open_loop_um", "error_at_table_um", "error_at_table_sd_um"}
    for key in set(SERIES) - lengths:
        np.testing.assert_array_equal(getattr(counted, key), getattr(usual, key), err_msg=key)
    began = counted.elongation_um[0]
    lo, hi = rig.screw.span_mm
    rise = counted.profile_C[0].mean() - 20.0
    assert began == pytest.approx(rig.screw.expansion * 1e3 * (hi - lo) * rise, rel=0.05)
    np.testing.assert_allclose(counted.open_loop_um - usual.open_loop_um, began, rtol=0, atol=1e-9)
    state = filter_.run.state
    x = filter_.fusion.x
    since = x[state.start] - 20.0 * state.growth.sum() + began * x[state.expansion]
    assert counted.elongation_um[-1] - usual.elongation_um[-1] == pytest.approx(since, abs=1e-9)
    assert (counted.sigma_um > rig.screw.expansion * 1e3 * (hi - lo) * 0.1).all()
    smooth = Replay(model, replace(rig, zero_C=20.0, zero_sd_K=0.1), recording, None, lambda _: None).smoothed()
    assert smooth.elongation_um[-1] == pytest.approx(counted.elongation_um[-1], abs=1e-9)
    assert smooth.sigma_um[-1] == pytest.approx(counted.sigma_um[-1], abs=1e-9)


def test_the_error_at_a_place_is_that_at_the_table_when_it_is_there(anywhere):
    model, rig, recording = anywhere
    waiting = recording.channels.copy()
    waiting[:5] = np.nan
    ticks, rig = [30, 70, 149], replace(rig, zero_C=20.0, zero_sd_K=0.1)
    seen = replace(recording, channels=waiting)
    found = Replay(model, rig, seen, None, lambda _: None, replay(model, rig, seen).position_mm[ticks])
    table, track = found.table, found.track
    assert table.error_um.shape == table.sd_um.shape == (len(recording), 3)
    assert np.isnan(table.error_um[:5]).all()
    at = ticks, range(3)
    np.testing.assert_allclose(table.error_um[at], track.error_at_table_um[ticks], rtol=1e-12)
    np.testing.assert_allclose(table.sd_um[at], track.error_at_table_sd_um[ticks], rtol=1e-12)
    np.testing.assert_array_equal(table.at(table.at_mm[[2, 0]]).error_um, table.error_um[:, [2, 0]])
    assert np.isfinite(table.error_um[5:]).all() == (rig.nut is not None and "anchor" in rig.supports)


def copy(run: Recording) -> Recording:
    """The recording with arrays of its own, to break."""
    own = {key: getattr(run, key).copy() for key in ("channels", "ages_s", "omega", "coverage")}
    return replace(run, inputs={name: column.copy() for name, column in run.inputs.items()}, **own)


def nothing(run: Recording) -> None:
    pass


def gaps(run: Recording) -> None:
    run.channels[np.random.default_rng(0).random(run.channels.shape) < 0.4] = np.nan


def whole_silent_ticks(run: Recording) -> None:
    run.channels[1] = run.channels[40:60] = run.channels[-3:] = np.nan


def late_readings(run: Recording) -> None:
    run.ages_s[:] = np.random.default_rng(0).uniform(0, 1.5, run.ages_s.shape)


def first_ticks_without_thermometer(run: Recording) -> None:
    run.channels[:7, :-1] = np.nan
    run.channels[2, -1] = 3.0


def first_sample_without_displacement(run: Recording) -> None:
    run.channels[:9, -1] = np.nan


def a_channel_that_comes_later(run: Recording) -> None:
    run.channels[:50, 2] = np.nan


def lost_drive_and_inputs(run: Recording) -> None:
    run.omega[40:43] = run.coverage[40:44] = run.inputs["position"][40:60] = np.nan
    run.inputs["ambient"][:25] = run.inputs["bar"][:] = np.nan


BREAKS = [
    nothing, gaps, whole_silent_ticks, late_readings, first_ticks_without_thermometer,
    first_sample_without_displacement, a_channel_that_comes_later, lost_drive_and_inputs,
]  # fmt: skip


@pytest.mark.parametrize("broken", BREAKS)
def test_replay_is_the_filter_with(broken, anywhere):
    model, rig, run = anywhere
    run = copy(run)
    broken(run)
    track = both(model, rig, run)
    assert len(track) == TICKS
    assert np.isfinite(track.elongation_um[-1])


def test_a_tick_without_readings_coasts_and_a_start_without_thermometer_waits(lived):
    model, rig, run = lived
    run = copy(run)
    first_ticks_without_thermometer(run)
    run.channels[30] = np.nan
    track = both(model, rig, run)
    assert (track.mode[:7] == Mode.INIT).all()
    assert np.isnan(track.elongation_um[:7]).all()
    assert np.isnan(track.profile_C[:7]).all()
    assert track.mode[30] == Mode.COASTING
    assert np.isnan(track.nis[30])


def left_out(track: Track, channel: int) -> list[int]:
    return np.flatnonzero(~track.fused[:, channel]).tolist()


def test_a_spike_is_refused_and_one_that_stays_is_left_out(lived):
    model, rig, run = lived
    run = copy(run)
    run.channels[30, 1] += SPIKE_K
    run.channels[60:, 2] += SPIKE_K
    track = both(model, rig, run)
    assert left_out(track, 1) == [30]
    assert left_out(track, 2) == list(range(60, TICKS))
    held = round(HELD_S / rig.tick_s)
    assert track.fault[60 : 60 + held, 2].tolist() == [Fault.JUDGED] * held
    assert (track.fault[60 + held :, 2] == Fault.JUMPED).all()
    np.testing.assert_array_equal(track.since_s[60:, 2], track.time_s[60])
    assert np.isnan(track.since_s[:60]).all() or np.flatnonzero(np.isfinite(track.since_s[:60, 1])).tolist() == [30]


def test_a_reading_missed_does_not_end_a_spike(lived):
    model, rig, run = lived
    run = copy(run)
    run.channels[60:75, 2] += SPIKE_K
    run.channels[63, 2] = np.nan
    assert left_out(both(model, rig, run), 2)[:15] == list(range(60, 75))


def test_a_thermometer_that_was_off_from_the_first_sample_on(lived):
    model, rig, run = lived
    run = copy(run)
    run.channels[:, 1] += SPIKE_K
    track = both(model, rig, run)
    assert left_out(track, 1) == list(range(TICKS))
    assert track.fault[-1, 1] == Fault.OFF


def test_all_thermometers_that_began_with_another_temperature(anywhere):
    """What they read before they were ready is no start: the run begins anew."""
    model, rig, run = anywhere
    run = copy(run)
    run.channels[:12, rig.is_thermometer] += SPIKE_K
    track = both(model, rig, run)
    assert track.elongation_um[12 + TOGETHER_TICKS - 1] == pytest.approx(0.0, abs=1e-9)
    assert left_out(track, 1) == list(range(12, 12 + TOGETHER_TICKS - 1))
    later = both(model, rig, run.rows(slice(12 + TOGETHER_TICKS - 1, None)))
    np.testing.assert_allclose(track.elongation_um[12 + TOGETHER_TICKS - 1 :], later.elongation_um, atol=1e-9)


def test_all_thermometers_that_jump_together_have_other_zeros(anywhere):
    model, rig, run = anywhere
    run, healthy = copy(run), replay(model, rig, run)
    from_ = TICKS - 25
    rig_is_warm = run.time_s[from_] - run.time_s[0] > START_S
    run.channels[from_:, rig.is_thermometer] += SPIKE_K
    track = both(model, rig, run)
    assert left_out(track, 1) == list(range(from_, from_ + TOGETHER_TICKS - (not rig_is_warm)))
    if rig_is_warm:
        error = abs(track.elongation_um - healthy.elongation_um)
        assert (error <= 4.0 * track.sigma_um + 0.01)[from_:].all()


def muted(*spans: tuple[int, float, float], rig: Rig) -> Callable[[float], np.ndarray]:
    """Mute channel i between two ticks, for each (i, from, to)."""

    def mute(time_s: float) -> np.ndarray:
        out = np.zeros(len(rig.names), dtype=bool)
        for i, lo, hi in spans:
            out[i] |= lo <= time_s / rig.tick_s < hi
        return out

    return mute


def test_muted_spans(anywhere):
    """Also from the start on, of all channels at a time, and over a spike, which is still there afterwards."""
    model, rig, run = anywhere
    run = copy(run)
    m = len(rig.names)
    run.channels[100:108, 2] += SPIKE_K
    spans = [(0, 0, 30), (m - 1, 50, 80), (2, 100, 103), *((i, 120, 125) for i in range(m))]
    track = both(model, rig, run, muted(*spans, rig=rig))
    assert not track.fused[:29, 0].any()
    assert track.fused[29, 0]
    assert np.isfinite(track.innovation[:29, 0]).all()
    assert not track.fused[49:79, -1].any()
    assert left_out(track, 2)[:9] == list(range(99, 108))
    assert (track.mode[119:124] == Mode.COASTING).all()


def test_a_channel_that_no_effect_reads_is_shown_but_never_fused(anywhere):
    model, rig, run = anywhere
    track = both(model - "displacement", rig, run)
    assert not track.fused[:, -1].any()
    assert np.isinf(track.innovation_sd[:, -1]).all()


def test_after_the_fact_the_estimate_is_as_sure_as_live_or_surer_and_the_same_at_the_end(anywhere):
    model, rig, run = anywhere
    found = Replay(model, rig, run, None, lambda _: None)
    smoothed, track = found.smoothed(), found.track
    assert smoothed.elongation_um[-1] == pytest.approx(track.elongation_um[-1], abs=1e-9)
    assert smoothed.sigma_um[-1] == pytest.approx(track.sigma_um[-1], abs=1e-9)
    assert (smoothed.sigma_um <= track.sigma_um + 1e-9).all()
    assert (smoothed.sigma_um[10:] / track.sigma_um[10:]).min() < 0.95
    assert abs(smoothed.elongation_um - track.elongation_um)[1:-1].max() > 1e-3


def test_what_the_gate_refused_is_not_smoothed_either(lived):
    model, rig, run = lived
    spiked, hole = copy(run), copy(run)
    spiked.channels[50, 2] += SPIKE_K
    hole.channels[50, 2] = np.nan
    a, b = (Replay(model, rig, log, None, lambda _: None).smoothed() for log in (spiked, hole))
    np.testing.assert_allclose(a.elongation_um, b.elongation_um, rtol=0, atol=1e-9)


def test_a_recording_that_ends_at_its_first_reading_or_before(lived):
    model, rig, run = lived
    run = copy(run)
    first_ticks_without_thermometer(run)
    assert np.isfinite(both(model, rig, run.rows(slice(0, 8))).elongation_um).sum() == 1
    assert both(model, rig, run.rows(slice(7, 8))).mode[0] != Mode.INIT
    assert (both(model, rig, run.rows(slice(0, 5))).mode == Mode.INIT).all()


def test_a_run_that_begins_anew_with_the_last_tick_has_nothing_to_smooth(lived):
    model, rig, run = lived
    run = copy(run)
    run.channels[:12, rig.is_thermometer] += SPIKE_K
    replayed = Replay(model, rig, run.rows(slice(0, 12 + TOGETHER_TICKS)), None, lambda _: None)
    assert (len(replayed.track), replayed.trial) == (12 + TOGETHER_TICKS, None)
    assert np.isnan(replayed.smoothed().elongation_um).all()


def test_each_hears_of_the_ticks_done_up_to_the_last(lived):
    model, rig, run = lived
    heard = []
    replay(model, rig, run, each=heard.append)
    assert heard == sorted(heard)
    assert heard[-1] == TICKS


def test_how_many_ticks_are_worked_out_at_a_time_does_not_matter(lived, monkeypatch):
    model, rig, run = lived
    monkeypatch.setattr(module, "ROWS", 7)
    both(model, rig, run)


class Heaters(Effect):
    """Two heaters warm each other and the room.

    C dT/dt = P Q - g (T - T_air) + g12 (T_other - T)
    """

    power = Param(0.008, "W/%", lo=0.0, hi=0.1, null=0.0)

    def terms(self, p, u, rig):
        for node in ("left", "right"):
            yield Store(node, 6.0, noise=0.01)
            yield Link(node, "ambient", 0.05)
        yield Link("left", "right", 0.03)
        yield Heat("left", p.power * u["Q1"])


def test_a_rig_without_a_screw(monkeypatch):
    """Long enough for more than one part."""
    monkeypatch.setattr(module, "ROWS", 128)
    channels = {"T1": Channel(node="left"), "T2": Channel(node="right")}
    rig = Rig("two heaters", 10.0, channels, {"Q1": Signal(unit="%"), "ambient": Signal()})
    model, ticks = model_of([Heaters, Thermometers]), module.ROWS + 150
    warm = 50.0 * (np.arange(ticks) // 60 % 2)
    none = np.zeros((ticks, 2))
    inputs = {"Q1": warm, "ambient": np.full(ticks, 22.0)}
    drive = Recording("heaters", 10.0 * np.arange(ticks), none, none, inputs, np.zeros(ticks), np.zeros((ticks, 0)))
    run = replace(drive, channels=23 + 0.1 * np.random.default_rng(2).standard_normal((ticks, 2)))
    run.channels[100:120, 1] = np.nan
    track = both(model, rig, run)
    assert track.bodies == ("left", "right")
    assert (track.bodies_C[1:, 0] - track.bodies_C[1:, 1]).max() > 0.5
    assert np.isnan(track.elongation_um).all()
    assert track.profile_C.shape == (ticks, 0)


def test_the_heated_rod():
    rig = load_rig(ROD)
    track = both(load_model(ROD / "model.toml"), rig, read_recording(ROD / "check.csv", rig).rows(slice(300)))
    assert track.fused.all()
    assert np.isnan(track.error_at_table_um).all()


def test_a_recording_of_the_bus(rig):
    """A drive and some minutes of its stop."""
    run = read_recording(PAPER / "FS-20.blf", rig).rows(slice(330))
    track = both(load_model(PAPER / "model.toml"), rig, run)
    assert track.fused[:, :15].mean() > 0.95
    assert track.fused[:, 15].sum() > 50
    assert abs(track.error_at_table_um).max() > 5


def test_regimes_that_were_forgotten_come_back_the_same(lived, monkeypatch):
    """A machine that never does the same twice meets more regimes than memory holds."""
    model, rig, recording = lived
    kept = Filter(model, rig)
    all_kept = [kept.step(sample) for sample in recording]
    assert len(kept.run.forcing._solved) > 3
    monkeypatch.setattr(filtering, "KEPT", 2)
    monkeypatch.setattr(regime, "REMEMBERED", 2)
    both(model, rig, recording)
    monkeypatch.setattr(regime, "REMEMBERED", 500)
    forgetful = Filter(model, rig)
    for step, sample in zip(all_kept, recording, strict=True):
        assert forgetful.step(sample).elongation_um == pytest.approx(step.elongation_um, abs=1e-12)
        assert len(forgetful.run.forcing._solved) <= 3
        assert len(forgetful._transitions) <= 2
