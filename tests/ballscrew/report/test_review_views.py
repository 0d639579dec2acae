"""What the views of a review say of validity and alarms is what the monitor says of the same frames."""

from dataclasses import replace

import numpy as np
import pytest

from ballscrew.monitor.monitor import Moment, Monitor
from ballscrew.report.review_views import judged
from estimator.faults.fault import Fault
from estimator.record import collect
from estimator.step import Track
from tests.live_fake import DRIVE, TELEMETERS, dropped, rig_frames

OF_THE_BUS = {"bus", "missing"}  # which a review does not see


@pytest.fixture(scope="module")
def moments(paper) -> list[tuple[Moment, tuple]]:
    """Each with the alarms that are on: without the thermometers for a while, then without the drive."""
    frames = dropped(dropped(rig_frames(70.0), 20.0, TELEMETERS, 40.0), 50.0, [DRIVE], 60.0)
    monitor = Monitor(paper[1], paper[0])
    return [(moment, tuple(monitor.active.values())) for frame in frames for moment in monitor.feed(frame)]


def test_review_finds_valid_what_the_monitor_found_valid(moments, paper):
    track = Track.of([moment.step for moment, _ in moments], np.empty(0), ())
    said = list(judged(collect("", [moment.sample for moment, _ in moments]), track, paper[0]))
    expected = []
    for moment, active in moments:
        alarms = tuple(alarm for alarm in active if alarm.kind not in OF_THE_BUS)
        if not expected or (moment.trust.why, alarms) != expected[-1][1:]:
            expected.append((moment.step.time_s, moment.trust.why, alarms))
    assert {why for _, why, _ in expected} == {(), ("fewer than 4 thermometers for 5 s",), ("no news of the drive",)}
    assert {alarm.kind for _, _, alarms in expected for alarm in alarms} == {"silent"}
    assert [(one.time_s, one.why, one.alarms) for one in said] == expected


def test_thermometers_that_are_muted_are_not_missed_but_broken_ones_are(moments, paper):
    """Three are left of fifteen: enough where the others were never to be used."""
    few = [moment for moment, _ in moments[:19]]
    track, samples = Track.of([moment.step for moment in few], np.empty(0), ()), [moment.sample for moment in few]
    fused = track.fused.copy()
    fused[:, :12] = False
    muted = replace(track, fused=fused)
    broken = replace(muted, fault=np.where(fused, Fault.NONE, Fault.STUCK), since_s=np.zeros(fused.shape))
    last = [list(judged(collect("", samples), each, paper[0]))[-1] for each in (muted, broken)]
    assert [one.why for one in last] == [(), ("fewer than 4 thermometers for 5 s",)]
    assert [{alarm.kind for alarm in one.alarms} for one in last] == [set(), {"stuck"}]
