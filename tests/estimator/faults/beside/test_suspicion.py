"""A thermometer that may drift: used with a zero that is not known, named, and the sd holds what it has led to."""

import copy
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drivers.recordings import read_recording
from drivers.virtual_rig import simulate, write
from estimator.batch.replay import Replay, replay
from estimator.faults.fault import Fault
from estimator.faults.sentences import sentences
from estimator.faults.use import Told, use_of
from estimator.filter import Filter
from estimator.rig_folder.model_toml import load_model
from estimator.step import SERIES
from tests.conftest import PAPER, stepped

SECONDS, AT, ONE = 3000, 1500, 4
SLOW = 0.35  # K/h: of 0.3 it hangs on a look whether it is suspected after 640 or 1050 s


@pytest.fixture(scope="module")
def healthy(strokes):
    return strokes(SECONDS)


@pytest.fixture(scope="module")
def usual(healthy, rig, shipped):
    """What the filter makes of it."""
    return replay(shipped, rig, healthy)


def drifting(healthy, K_per_h, seconds=SECONDS):
    """Thermometer ONE drifts from AT on, for so many seconds; and back, in five times as many."""
    readings, peak = healthy.channels.copy(), K_per_h / 3600 * seconds
    readings[:, ONE] += np.interp(np.arange(len(healthy)), [AT, AT + seconds, AT + 6 * seconds], [0.0, peak, 0.0])
    return replace(healthy, channels=readings)


@pytest.fixture(scope="module")
def found(healthy, rig, shipped):
    """found(K_per_h): the recording that drifts by so much to its end, and its replay; each asked once."""

    @cache
    def of(K_per_h):
        recording = drifting(healthy, K_per_h)
        return recording, Replay(shipped, rig, recording, None, lambda _: None)

    return of


def suspected(track):
    """The ticks at which ONE may drift."""
    return np.flatnonzero(track.may_drift_K[:, ONE])


def test_of_healthy_thermometers_none_is_suspected(usual):
    assert not usual.may_drift_K.any()


def test_of_healthy_thermometers_that_scatter_more_than_the_model_says_none_is_suspected(healthy, rig, shipped):
    """Another machine's may be others; what they scatter by is seen, and no drift."""
    noise = np.random.default_rng(8).normal(0.0, 0.04, healthy.channels.shape)
    noisy = replace(healthy, channels=healthy.channels + np.where(rig.is_thermometer, noise, 0.0))
    assert not replay(shipped, rig, noisy).may_drift_K.any()


def test_a_drift_is_suspected_and_used_before_it_is_accused(found):
    track = found(6.0)[1].track
    first, accused = suspected(track)[0], np.flatnonzero(track.fault[:, ONE] == Fault.DRIFTING)[0]
    assert first - AT <= 70
    assert first < accused
    assert track.fused[first:accused, ONE].all()
    assert (track.since_s[first:accused, ONE] == track.time_s[first]).all()
    assert not suspected(track)[-1] >= accused
    assert not np.delete(track.may_drift_K, ONE, axis=1).any()


def test_a_slow_drift_that_is_suspected_leads_the_estimate_no_further(found, usual, paper):
    """Its zero goes with it, where a known one would take the estimate along by 0.2 um; the sd holds what it did.
    Before, it holds how far it departs, which may as well be what the model lacks."""
    rig, track = paper[0], found(SLOW)[1].track
    first = suspected(track)[0]
    assert first - AT < 1000
    assert not track.fault.any()
    added = abs(track.elongation_um - usual.elongation_um)
    assert added[1:].max() < 0.1
    assert (added <= 2 * track.sigma_um).all()
    assert track.may_drift_K[-1, ONE] == pytest.approx(SLOW / 3600 * (SECONDS - AT), rel=0.3)
    near = np.argmin(abs(track.x_mm - rig.channels[rig.names[ONE]].at_mm))
    assert track.profile_sd_K[-1, near] > 2 * usual.profile_sd_K[-1, near]
    assert track.error_at_table_sd_um[-1] > usual.error_at_table_sd_um[-1]
    before = track.sigma_um[1:first] / usual.sigma_um[1:first]
    assert before.min() > 0.999
    assert 1.02 < before[-1] < 1.1


def test_a_suspicion_passes_and_estimate_and_sd_are_as_they_were(healthy, usual, rig, shipped):
    """But for a zero that the model has to tell anew, as well as its process noise lets it: 3.5 % of the sd."""
    track = replay(shipped, rig, drifting(healthy, 0.7, 200))
    at = suspected(track)
    assert at[0] < AT + 200 < at[-1] < AT + 1200
    assert not track.fault.any()
    np.testing.assert_allclose(track.sigma_um[at[-1] + 1 :], usual.sigma_um[at[-1] + 1 :], rtol=0.04)
    np.testing.assert_allclose(track.elongation_um[at[-1] + 1 :], usual.elongation_um[at[-1] + 1 :], atol=0.04)
    assert np.isnan(track.since_s[at[-1] + 1 :, ONE]).all()


def test_where_strokes_heat_its_place_a_drift_is_suspected_within_minutes(rig, shipped, tmp_path):
    """The model alone changes T06 by 1 K beside its neighbours meanwhile: 5 % and 0.05 K of it may be wrong.

    After 270 - 310 s with seeds 6 - 9.
    """
    recording = read_recording(write(simulate("CS-10", seed=6, seconds=600), tmp_path / "short.log"), rig)
    assert not replay(shipped, rig, recording).may_drift_K.any()
    readings, i = recording.channels.copy(), rig.index("T06")
    readings[:, i] += np.interp(np.arange(len(recording)), [250, 600], [0.0, 3.0 * 350 / 3600])
    track = replay(shipped, rig, replace(recording, channels=readings))
    at = np.flatnonzero(track.may_drift_K[:, i])
    assert 250 < at[0] < 250 + 300
    assert not np.delete(track.may_drift_K, i, axis=1).any()


@pytest.fixture
def drifts_on_7(paper, tmp_path):
    """drifts_on_7(experiment, at_s, channel, factors): on machine 7 a thermometer drifts by 3 K/h from a time on.

    By the model that was fitted to it, some parameters so many times as large: the track, from when on, its error then.
    """

    def of(name, at_s, channel, factors=None):
        rig, model = paper[0], load_model(PAPER / "machine-7" / "healthy.toml")
        model = model.with_values({path: model[path] * by for path, by in (factors or {}).items()})
        run = simulate(name, machine=7, seed=3, seconds=at_s + 1500)
        recording = read_recording(write(run, tmp_path / "7.log"), rig)
        recording.channels[:, rig.index(channel)] += np.maximum(recording.time_s - at_s, 0.0) * 3.0 / 3600.0
        track = replay(model, rig, recording)
        now, true_um = track.time_s >= at_s, np.interp(track.time_s, run.truth.time_s, run.truth.elongation_um)
        return track, now, np.abs(true_um - track.elongation_um)[now]

    return of


def test_a_thermometer_that_drifts_is_no_witness_that_the_model_is_wrong(drifts_on_7):
    """At the edge of short strokes, where it is suspected late."""
    track, now, off_um = drifts_on_7("CS-20", 150, "T04")
    assert track.off_share[now].max() < 0.03
    assert track.may_drift_K[now, 3].any()
    assert off_um.max() < 0.5


def test_a_drift_leads_no_further_by_a_model_that_is_off_by_little(drifts_on_7):
    """Whose share is beyond the least that is asked for, as after most fits it is now and then."""
    track, now, off_um = drifts_on_7("FS-20", 1500, "T05", {"anchor_friction.power": 1.2})
    assert 1 / 32 < track.off_share[now].max() < 1 / 16
    assert off_um.max() < 0.3


def test_on_a_machine_that_is_not_the_models_zeros_stay(rig, shipped, tmp_path):
    """What the model misses is as likely heat: T14 is off by 0.15 K, and right."""
    log = write(simulate("CS-20", machine=128, seed=128, seconds=330), tmp_path / "b.log")
    track = replay(shipped, rig, read_recording(log, rig))
    first = np.flatnonzero(track.may_drift_K[:, 13])[0]
    assert track.off_share[first] > 0.1
    assert track.innovation[first : first + 4, 13].max() < -0.1
    assert not (track.fault > Fault.JUDGED).any()


def test_live_suspects_and_widens_as_batch_does(healthy, rig, shipped):
    """Two that drift from soon after the stop on, one of them so slowly that it is not accused yet."""
    begun = healthy.rows(slice(0, 560))
    recording = replace(begun, channels=begun.channels.copy())
    recording.channels[360:363] = np.nan
    for i, K_per_h in ((ONE, 4.0), (ONE + 5, 14.0)):
        recording.channels[:, i] += np.maximum(recording.time_s - 300.0, 0.0) * K_per_h / 3600.0
    live, batch = stepped(Filter(shipped, rig), recording), replay(shipped, rig, recording)
    assert suspected(batch).size
    assert not batch.fault[:, ONE].any()
    assert batch.fault[-1, ONE + 5] == Fault.DRIFTING
    for key in SERIES:
        np.testing.assert_allclose(getattr(live, key), getattr(batch, key), rtol=1e-9, atol=1e-9, err_msg=key)


def test_after_the_fact_what_may_drift_is_not_heard(found, healthy, rig, shipped):
    _, replayed = found(SLOW)
    smoothed, usual = replayed.smoothed(), Replay(shipped, rig, healthy, None, lambda _: None).smoothed()
    assert smoothed.sigma_um[-1] == pytest.approx(replayed.track.sigma_um[-1], rel=0.02)
    after = suspected(replayed.track)[0] + 1
    assert (abs(smoothed.elongation_um - usual.elongation_um)[after:] < 0.1).all()


def test_after_the_fact_what_has_drifted_is_not_heard_again(found):
    """Though it is taken back: its zero is another one."""
    replayed = copy.copy(found(6.0)[1])
    usual, track = replayed.smoothed(), replayed.track
    back = np.flatnonzero(track.fault[:, ONE] == Fault.DRIFTING)[0] + 60
    fault, fused = track.fault.copy(), track.fused.copy()
    fault[back:, ONE], fused[back:, ONE] = Fault.NONE, True
    replayed.track = replace(track, fault=fault, fused=fused)
    np.testing.assert_array_equal(replayed.smoothed().elongation_um, usual.elongation_um)


@pytest.mark.parametrize(("K_per_h", "said"), [(SLOW, True), (6.0, False)], ids=["used", "left out"])
def test_it_is_said_of_a_recording_but_of_what_was_accused_then(K_per_h, said, found, paper):
    rig, (recording, replayed) = paper[0], found(K_per_h)
    track = replayed.track
    use = use_of(recording, rig, Told.by(track))
    first = track.time_s[suspected(track)[0]]
    told = [sentence for sentence in sentences([use], rig) if "may have drifted" in sentence]
    at = f"T05 at {rig.channels['T05'].at_mm:g} mm may have drifted by"
    ends = f"K, from {first:.0f} s on: it is used, with a zero that is not known by as much"
    assert [at in each and each.endswith(ends) for each in told] == [True] * said
    assert bool(use.channels[ONE].suspicions) == said
    assert use.channels[ONE].suspect == (Fault.NONE if said else Fault.DRIFTING)
