"""Lanes read back from a saved file, against what the review itself has noted of each tick."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

from estimator.faults.fault import Fault
from estimator.inputs.phase import turns
from estimator.step import Mode
from tests.viz_fake import fake_run
from tests.viz_read import fixed, state_at
from viz.drawing import paths
from viz.lanes.standing import Judged
from viz.lanes.states import LASTS_S, States, telling
from viz.recorded.recorded import save
from viz.recorded.run import ReviewedRun

SECONDS = 900
MOMENTS = (15.0, 100.0, 235.0, 300.0, 345.0, 420.0, 500.0, 595.0, 615.0, 639.0, 700.0, 899.0)


@pytest.fixture(scope="module")
def run() -> ReviewedRun:
    """T03 has jumped from 320 to 480 s, T05 is muted after 400 s, T07 silent from 600 to 640 s, T09 suspect to 450."""
    run = fake_run("FS-20", SECONDS)
    track, time_s = run.track, run.track.time_s
    fused, fault, may_drift_K = track.fused.copy(), track.fault.copy(), track.may_drift_K.copy()
    jumped, muted, suspected = (time_s > 320) & (time_s <= 480), time_s > 400, (time_s > 380) & (time_s <= 450)
    fault[jumped, 2], fused[jumped, 2], fused[muted, 4], may_drift_K[suspected, 8] = Fault.JUMPED, False, False, 0.1
    since_s = np.where(jumped[:, None], 321.0, np.where(suspected[:, None], 381.0, track.since_s))
    changed = {"fused": fused, "fault": fault, "may_drift_K": may_drift_K, "since_s": since_s}
    return replace(run, track=replace(track, **changed))


@pytest.fixture(scope="module")
def saved(run: ReviewedRun, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("lanes") / "run.rrd"
    save(path, [run], "")
    return path


def test_lanes_say_of_each_channel_what_the_review_has_noted(run: ReviewedRun, saved: Path) -> None:
    track = run.track
    lanes = {str(path) for path in _lanes(saved) if "/channel_state/" in str(path)}
    for when in MOMENTS:
        k = int(np.flatnonzero(track.time_s == when)[0])
        for i, name in enumerate(track.names[:15]):
            lane = f"/FS-20/channel_state/{name}"
            said = state_at(saved, lane, when)[0] if lane in lanes else "used"
            if track.fused[k, i]:
                assert said == ("suspect: may drift" if track.may_drift_K[k, i] else "used"), (when, name)
            elif np.isnan(track.measured[k, i]):
                assert said == "silent", (when, name)
            else:
                assert said == ("refused: jumped" if track.fault[k, i] else "muted"), (when, name)
        used = int(track.fused[k, :15].sum())
        assert state_at(saved, "/FS-20/state/thermometers", when) == [f"{used} of 15 used"]
    assert {lane.rpartition("/")[2] for lane in lanes} >= {"T03", "T05", "T07", "T09"}
    assert "/FS-20/channel_state/T01" not in lanes  # it was used all the time


def test_lanes_say_what_the_machine_did_and_when_the_estimate_was_valid(run: ReviewedRun, saved: Path) -> None:
    for when in MOMENTS:
        k = int(np.flatnonzero(run.track.time_s == when)[0])
        assert state_at(saved, "/FS-20/state/drive", when) == [
            "driving" if turns(run.recording.omega[k]) else "at rest"
        ]
        why = [judged.why for judged in run.judged if judged.time_s <= when][-1]
        assert state_at(saved, "/FS-20/state/estimate", when) == [", ".join(why) or "valid"]


def test_each_reason_has_a_colour_of_its_own(saved: Path) -> None:
    """And red is what makes the estimate invalid."""
    red = paths.LEFT_OUT
    assert paths.lane_colour("state/estimate", "no news of the drive") == red
    words = ("used", "silent", "muted", "suspect: may drift", "refused: stuck")
    colours = [paths.lane_colour("channel_state/T03", text) for text in words]
    assert len({*colours}) == len(words)
    assert red not in colours
    kinds = [paths.lane_colour(f"state/faults/{kind}", "T03") for kind in ("stuck", "silent", "may_drift")]
    assert len({*kinds}) == 3
    assert red not in kinds
    assert fixed(saved, "/FS-20/channel_state/T03", "StateConfiguration:values") == ["", "used", "refused: jumped"]


def test_what_alternates_with_each_tick_is_one_state(run: ReviewedRun) -> None:
    """A reading each ninth second, and none between."""
    states, told = States(run.rig), []
    for k in range(200):
        step = replace(run.track.step(k, ()), mode=Mode.UPDATE if k % 9 == 0 else Mode.PREDICT)
        told += [(s.text, s.since_s) for s in states.tick(run.recording.sample(k), step) if s.lane == paths.MODE]
    assert told == [("update: displacement read", 1.0)]


def test_what_does_not_last_is_not_told_and_what_does_is_from_when_it_began(run: ReviewedRun) -> None:
    states, told = States(run.rig), []
    for k in range(120):
        omega = 174.5 if 30 <= k < 30 + LASTS_S - 1 or k >= 80 else 0.0
        sample = replace(run.recording.sample(k), omega=omega)
        told += [(s.text, s.since_s) for s in states.tick(sample, run.track.step(k, ())) if s.lane == paths.DRIVE]
    assert told == [("at rest", 1.0), ("driving", 81.0)]


def test_a_run_that_begins_anew_has_lanes_of_its_own(run: ReviewedRun) -> None:
    states = States(run.rig)
    first = [s for k in range(50) for s in states.tick(run.recording.sample(k), run.track.step(k, ()))]
    second = [s for k in range(50) for s in states.tick(run.recording.sample(k), run.track.step(k, ()))]
    assert first == second
    assert {s.lane for s in states.again()} >= {paths.DRIVE, paths.MODE, paths.THERMOMETERS}


def test_what_is_sent_is_a_lane_where_somebody_may_listen() -> None:
    assert "published" not in Judged(1.0, (), ()).states
    assert Judged(1.0, (), (), "not publishing: another sender").states["published"] == (
        "not publishing: another sender",
        1.0,
    )
    assert paths.lane_colour("state/published", "sent") != paths.lane_colour("state/published", "sent as invalid")


def _lanes(path: Path) -> set[object]:
    return {chunk.entity_path for chunk in RrdReader(path).stream().to_chunks()}


def test_ticks_that_tell_nothing_new_are_left_out_and_change_nothing(run: ReviewedRun) -> None:
    omega = run.recording.omega.copy()
    omega[700:720] = np.nan
    recording = replace(run.recording, omega=omega)

    def told(ticks: list[int]) -> list:
        states = States(run.rig)
        found = [each for k in ticks for each in states.tick(recording.sample(k), run.track.step(k, ()))]
        return [*found, *states.end()]

    shown = telling(run.track, omega).tolist()
    assert told(shown) == told(list(range(SECONDS)))
    assert len(shown) < 0.8 * SECONDS
