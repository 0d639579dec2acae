"""What live views send of some ticks: pictures, lanes and words when they change."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from estimator.step import TableErrors
from tests.viz.live.conftest import WAITING, Fed
from tests.viz_fake import SILENT
from tests.viz_read import rows
from viz.drawing.entity import Entity
from viz.lanes.standing import Glance, Judged, Standing
from viz.live.live import LiveViews
from viz.live.repeat import Repeated
from viz.live.rows import Rows


def test_travelled_is_where_the_table_has_been(fed: Fed, tmp_path: Path) -> None:
    """And nothing of the time at which that was not known."""
    rec, rig = rr.RecordingStream("ballscrew"), fed.run.rig
    rec.save(tmp_path / "some.rrd")
    some, place_mm = Rows(Entity(rec, "FS-20"), rig, True, 3600.0), [np.nan, np.nan, 300.0, 180.0, 240.0]
    for k, at_mm in enumerate(place_mm):
        sample, step = fed.ticks[100 + k]
        stroke = TableErrors(np.linspace(*rig.stroke_mm, 3), np.full((1, 3), 2.0), np.full((1, 3), 0.1))
        some.send(
            [(sample, replace(step, position_mm=at_mm))],
            [],
            Standing(step.time_s, (Glance("", "", "", "stale"),), "", stroke),
        )
    rec.disconnect()
    found = rows(tmp_path / "some.rrd", "/FS-20/stroke/travelled", "LineStrips2D:strips")[1]
    width = 1000.0 / (rig.stroke_mm[1] - rig.stroke_mm[0])
    (left, right) = (x for x, _ in found[-1][0])
    assert (right - left) / width == pytest.approx(120.0, abs=0.01)


def test_nothing_is_drawn_as_sent_that_was_not(fed: Fed, tmp_path: Path) -> None:
    """Of one batch, whose judgements come with their own times."""
    rec = rr.RecordingStream("ballscrew")
    rec.save(tmp_path / "some.rrd")
    judged = [Judged(0.0, (), (), "sent"), Judged(50.0, ("x",), (), "sent as invalid"), Judged(90.0, (), (), "sent")]
    Rows(Entity(rec, "FS-20"), fed.run.rig, False, 3600.0).send(fed.ticks[:120], judged, None)
    rec.disconnect()
    time_s = rows(tmp_path / "some.rrd", "/FS-20/table/sent", "Scalars:scalars")[0]
    np.testing.assert_array_equal(time_s, [*range(WAITING + 1, 50), *range(90, 121)])


@pytest.mark.parametrize("newest", [False, True])
def test_how_things_stand_is_sent_when_it_changes(fed: Fed, tmp_path: Path, newest: bool) -> None:
    """The banner to who looks on, not into a file, which is looked through at other moments."""
    rec, ((_, step),) = rr.RecordingStream("ballscrew"), fed.ticks[:1]
    rec.save(tmp_path / "x.rrd")
    some = Rows(Entity(rec, "FS-20"), fed.run.rig, newest, 3600.0)
    for k, value in enumerate(("+1.00 µm", "+1.00 µm", "+2.00 µm")):
        some.send([], [], Standing(step.time_s + k, (Glance("elongation", value, "", "value"),), "at rest"))
    rec.disconnect()
    assert list(rows(tmp_path / "x.rrd", "/FS-20/status", "TextDocument:text")[0]) == [step.time_s]
    lanes = {str(chunk.entity_path) for chunk in RrdReader(tmp_path / "x.rrd").stream().to_chunks()}
    assert ("/FS-20/banner" in lanes) == newest
    if newest:
        times = rows(tmp_path / "x.rrd", "/FS-20/banner", "EncodedImage:blob")[0]
        assert list(times) == [step.time_s, step.time_s + 2]


@pytest.mark.parametrize(("newest", "batch", "gaps"), [(False, 1, {10.0}), (True, 1, {1.0}), (True, 50, {1.0, 10.0})])
def test_pictures_come_every_ten_seconds_and_with_the_newest_tick(
    fed: Fed, tmp_path: Path, newest: bool, batch: int, gaps: set[float]
) -> None:
    rec = rr.RecordingStream("ballscrew")
    rec.save(tmp_path / "some.rrd")
    some = Rows(Entity(rec, "FS-20"), fed.run.rig, newest, 3600.0)
    for k in range(0, 100, batch):
        some.send(fed.ticks[k : k + batch], [], None)
    rec.disconnect()
    time_s = rows(tmp_path / "some.rrd", "/FS-20/profile/estimate", "LineStrips2D:strips")[0]
    assert set(np.diff(time_s)[1:]) <= gaps
    assert time_s[0] == WAITING + 1


def test_a_viewer_that_comes_late_hears_again_what_is_broken_since_long_ago(fed: Fed, tmp_path: Path) -> None:
    views = LiveViews(fed.run.rig, "FS-20", port=None, save=tmp_path / "x.rrd")
    for time_s in np.arange(610.0, 1900.0):
        views.judge(time_s, (), (SILENT,))
    views.close()
    time_s, states = rows(tmp_path / "x.rrd", "/FS-20/state/faults/silent", "StateChange:state")
    np.testing.assert_array_equal(time_s, [600.0, 1210.0, 1810.0])
    assert states == [["T07"]] * 3


def test_lanes_of_a_run_that_begins_anew_are_on_its_own_clock(fed: Fed, tmp_path: Path) -> None:
    views = LiveViews(fed.run.rig, "FS-20", port=None, save=tmp_path / "x.rrd")
    views.judge(7000.0, (), (SILENT,))
    views.judge(7100.0, (), ())
    views.judge(30.0, (), (replace(SILENT, since_s=20.0),))
    views.close()
    time_s, states = rows(tmp_path / "x.rrd", "/FS-20/state/faults/silent", "StateChange:state")
    assert list(zip(time_s, states, strict=True)) == [(30.0, ["T07"]), (600.0, ["T07"]), (7100.0, [""])]


def test_what_seldom_changes_is_repeated() -> None:
    seldom = Repeated[str](600.0)
    assert [seldom.due(*each) for each in (("a", 0.0), ("a", 599.0), ("b", 599.5), ("b", 1199.0), ("b", 1199.5))] == [
        True, False, True, False, True,
    ]  # fmt: skip
