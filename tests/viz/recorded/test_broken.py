"""Thermometers that are broken, or may drift, in the views of a recording."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.alarms.alarms import Alarm
from estimator.faults.fault import MAY_DRIFT, Fault
from tests.viz_read import pixels, rows
from viz.drawing.paths import MAPS
from viz.drawing.scale import UNKNOWN
from viz.lanes.standing import Judged
from viz.recorded.recorded import save
from viz.recorded.run import ReviewedRun


@pytest.fixture(scope="module")
def jumped(run: ReviewedRun) -> ReviewedRun:
    """The third thermometer reads 40 K too much after 300 s."""
    now = run.track.time_s > 300
    measured, innovation, fault, since_s = (
        array.copy() for array in (run.track.measured, run.track.innovation, run.track.fault, run.track.since_s)
    )
    measured[now, 2], innovation[now, 2] = measured[now, 2] + 40, innovation[now, 2] + 40
    fault[now, 2], since_s[now, 2] = Fault.JUMPED, 301.0
    track = replace(run.track, measured=measured, innovation=innovation, fault=fault, since_s=since_s)
    return replace(run, track=track)


def test_what_is_broken_is_named_in_the_profile_and_stretches_nothing(jumped, run, tmp_path):
    assert jumped.scale.temperature_C == run.scale.temperature_C
    assert jumped.scale.innovation_K == run.scale.innovation_K
    save(tmp_path / "jumped.rrd", [jumped], "")
    time_s, labels = rows(tmp_path / "jumped.rrd", "/FS-20/profile/faults", "Points2D:labels")
    for t, row in zip(time_s, labels, strict=True):
        assert (row or []) == (["T03 jumped since 0:05:01"] if t > 300 else [])


def test_what_may_drift_is_named_in_the_profile_and_in_a_lane_of_its_own(run, tmp_path):
    now = run.track.time_s > 300
    may_drift_K, since_s = run.track.may_drift_K.copy(), run.track.since_s.copy()
    may_drift_K[now, 2], since_s[now, 2] = 0.123, 301.0
    alarm = Alarm(MAY_DRIFT, "T03", 301.0, "T03 may drift")
    judged = [Judged(1.0, (), ()), Judged(301.0, (), (alarm,)), Judged(400.0, (), ())]
    suspected = replace(run, track=replace(run.track, may_drift_K=may_drift_K, since_s=since_s), judged=judged)
    save(tmp_path / "suspected.rrd", [suspected], "")
    time_s, labels = rows(tmp_path / "suspected.rrd", "/FS-20/profile/faults", "Points2D:labels")
    for t, row in zip(time_s, labels, strict=True):
        assert (row or []) == (["T03 may drift, +0.12 K since 0:05:01"] if t > 300 else [])
    time_s, states = rows(tmp_path / "suspected.rrd", "/FS-20/state/faults/may_drift", "StateChange:state")
    assert list(zip(time_s, np.ravel(states), strict=True)) == [(301.0, "T03"), (400.0, "")]


def test_what_is_broken_is_grey_in_the_maps(jumped, saved, tmp_path):
    save(tmp_path / "jumped.rrd", [jumped], "")
    for drawn in MAPS:
        after, before = (pixels(path, f"/FS-20/{drawn}/picture") for path in (tmp_path / "jumped.rrd", saved))
        changed = np.argwhere((after != before).any(axis=-1))
        assert set(changed[:, 0]) == {2}
        assert changed[:, 1].min() == 5
        assert {tuple(pixel) for pixel in after[2, 6:]} == {UNKNOWN}
