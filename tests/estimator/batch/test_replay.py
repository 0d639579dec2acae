"""The replay of a whole recording gives the numbers of the filter that takes it a tick at a time."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.recordings import read_recording
from estimator import filter as filtering, step as steps
from estimator.batch import replay as module
from estimator.batch.replay import Replay, replay
from estimator.cover import Cover
from estimator.effect import Effect, Param
from estimator.effects.readings import Thermometers
from estimator.filter import Filter
from estimator.inputs import inputs
from estimator.model import model_of
from estimator.network import forcing, regime
from estimator.record import Recording
from estimator.rig import Channel, Rig, Signal
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.sensitivity.tangent import tangent
from estimator.step import PROFILES, SERIES, Mode
from estimator.terms import Heat, Link, Store
from tests.conftest import PAPER, ROD, stepped
from tests.estimator.batch.conftest import TICKS, both, copy


def test_counted_from_a_zero_only_lengths_are_others(anywhere):
    """By what by now is known to have been grown at the first sample, another coefficient included."""
    model, rig, recording = anywhere
    counted, filter_ = both(model, replace(rig, zero_C=20.0, zero_sd_K=0.1), recording), Filter(model, rig)
    usual = stepped(filter_, recording)
    lengths = {"elongation_um", "sigma_um", "open_loop_um", "error_at_table_um", "error_at_table_sd_um", "unsure_um"}
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


def test_a_long_run_is_worked_out_some_ticks_at_a_time(anywhere, monkeypatch):
    """Of those in which nothing is known of the drive too; its profiles are kept in single precision."""
    model, rig, recording = anywhere
    recording = copy(recording)
    recording.omega[40:43] = recording.coverage[60:64] = np.nan
    path = next(path for path in model.free() if path.startswith("nut_friction"))
    tracks, slopes = [], []
    for long in (10**9, 20):
        for each in (inputs, forcing, steps):
            monkeypatch.setattr(each, "LONG", long)
        monkeypatch.setattr(forcing, "AT_ONCE", 17)
        found = Replay(model, rig, recording.packed(), None, lambda _: None)
        assert isinstance(found.trial.drive.inputs.coverage, Cover) == (long == 20)
        tracks.append(found.track)
        slopes.append(tangent(found.trial, found.trial.pose(model), model, path))
    for key in SERIES:
        digits = {"rtol": 1e-7 if key in PROFILES else 1e-11, "atol": 1e-12}  # few ticks: products in another order
        np.testing.assert_allclose(*(getattr(one, key) for one in tracks), **digits, err_msg=key)
    for key in ("heat", "outside", "offset"):
        np.testing.assert_allclose(*(getattr(one, key) for one in slopes), rtol=1e-11, atol=1e-12, err_msg=key)


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
    gaps, whole_silent_ticks, late_readings, first_ticks_without_thermometer,
    first_sample_without_displacement, a_channel_that_comes_later, lost_drive_and_inputs,
]  # fmt: skip


TOGETHER = {
    "gaps": (gaps,),
    "late": (whole_silent_ticks, late_readings, a_channel_that_comes_later),
    "a late start": (first_ticks_without_thermometer,),
    "no drive": (first_sample_without_displacement, lost_drive_and_inputs),
}


@pytest.mark.parametrize("broken", TOGETHER)
def test_replay_is_the_filter_with(broken, lived):
    model, rig, run = lived
    run = copy(run)
    for each in TOGETHER[broken]:
        each(run)
    track = both(model, rig, run)
    assert len(track) == TICKS
    assert np.isfinite(track.elongation_um[-1])


def test_replay_is_the_filter_on_the_papers_rig_with_all_of_it_at_once(on_the_papers_rig):
    model, rig, run = on_the_papers_rig
    run = copy(run)
    for broken in BREAKS:
        broken(run)
    assert np.isfinite(both(model, rig, run).elongation_um[-1])


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


def test_a_recording_that_ends_at_its_first_reading_or_before(lived):
    model, rig, run = lived
    run = copy(run)
    first_ticks_without_thermometer(run)
    assert np.isfinite(both(model, rig, run.rows(slice(0, 8))).elongation_um).sum() == 1
    assert both(model, rig, run.rows(slice(7, 8))).mode[0] != Mode.INIT
    assert (both(model, rig, run.rows(slice(0, 5))).mode == Mode.INIT).all()


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
    track = both(load_model(ROD / "model.toml"), rig, read_recording(ROD / "check.csv", rig).rows(slice(150)))
    assert track.fused.all()
    assert np.isnan(track.error_at_table_um).all()


def test_a_recording_of_the_bus(rig, fs20_log):
    """A drive and the beginning of its stop."""
    run = read_recording(fs20_log, rig).rows(slice(280))
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
