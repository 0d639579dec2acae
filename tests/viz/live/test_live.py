"""Live views: what a stream shows and a file keeps, who can reach them, and that they stop nobody."""

from __future__ import annotations

import socket
import sys
import urllib.error
import urllib.request
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from estimator.errors import InputError, SetupError
from estimator.filter import Filter
from estimator.record import Sample
from estimator.rig import Rig
from estimator.step import Mode, Step, TableErrors, Track
from tests.conftest import at_defaults
from tests.processes import PATIENCE_S, until
from tests.viz_fake import JUDGED, SILENT, fake_run
from tests.viz_read import fixed, rows, state_at, view_names
from viz.drawing import profile
from viz.drawing.entity import Entity
from viz.drawing.file import begin, stream
from viz.drawing.views import sliding
from viz.lanes.judged import Judged
from viz.lanes.standing import Glance, Standing
from viz.live import live, outlet
from viz.live.body import frame_of
from viz.live.layout import blueprint
from viz.live.live import LiveViews
from viz.live.repeat import Repeated
from viz.live.rows import Rows
from viz.live.scale import Decades, Growing
from viz.live.table import LINE
from viz.recorded.recorded import save
from viz.recorded.run import ReviewedRun
from viz.viewer import viewer
from viz.viewer.address import free_port
from viz.viewer.web import WebPage

SECONDS, WAITING, BATCH = 400, 5, 50
Ticks = list[tuple[Sample, Step]]
UNUSED = "Channels that are not used all the time"
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc, or has no screen")


class Fed(NamedTuple):
    """A run whose first ticks have no thermometer, its ticks one by one, and the file that live views made of them, and
    of the error over the stroke at last."""

    run: ReviewedRun
    ticks: Ticks
    file: Path
    stroke: TableErrors


def show(views: LiveViews, ticks: Ticks, batch: int = BATCH) -> None:
    """Show ticks, sent in batches."""
    for k, (sample, step) in enumerate(ticks):
        views.show(sample, step)
        if k % batch == batch - 1:
            views.flush()


@pytest.fixture(scope="module")
def fed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Fed]:
    """In strict mode: a value that the format does not know raises."""
    rr.set_strict_mode(True)
    run = fake_run("FS-20", SECONDS)
    channels = run.recording.channels.copy()
    channels[:WAITING] = np.nan
    recording = replace(run.recording, channels=channels)
    estimate = Filter(at_defaults(), run.rig)
    ticks = [(sample, estimate.step(sample)) for sample in recording]
    track = Track.of([step for _, step in ticks], run.track.x_mm, ())
    file = tmp_path_factory.mktemp("live") / "live.rrd"
    views = LiveViews(run.rig, "FS-20", port=None, save=file)
    views.say(21.0, "drive starts")
    for judged in JUDGED:
        views.judge(judged.time_s, judged.why, judged.alarms, "" if judged.why else "sent")
    show(views, ticks)
    stroke = estimate.table_errors(np.linspace(*run.rig.stroke_mm, 41))
    views.stand(Standing(float(SECONDS), (Glance("elongation", "+1.00 µm", "", "value"),), "**at rest**", stroke))
    views.close()
    assert views.trouble == ""
    yield Fed(replace(run, recording=recording, track=track), ticks, file, stroke)
    rr.set_strict_mode(False)


@pytest.fixture(scope="module")
def saved(fed: Fed, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same run saved afterwards."""
    path = tmp_path_factory.mktemp("saved") / "saved.rrd"
    save(path, [fed.run], "")
    return path


@contextmanager
def served(rig: Rig, **how: Any) -> Iterator[LiveViews]:
    views = LiveViews(rig, "live", **{"port": 0, **how})
    try:
        yield views
    finally:
        views.close()


# --- what is shown


@pytest.mark.parametrize(
    ("entity", "component"),
    [
        ("elongation/filter", "Measurements:values"),
        ("elongation/filter", "Measurements:variances"),
        ("channels/temperature/1", "Scalars:scalars"),
        ("channels/temperature/2", "Scalars:scalars"),
        ("channels/innovation/1", "Scalars:scalars"),
        ("nis/window", "Scalars:scalars"),
        ("nis/bounds", "Scalars:scalars"),
        ("screw/nut", "Transform3D:translation"),
    ],
)
def test_live_rows_are_those_of_a_saved_file(fed: Fed, saved: Path, entity: str, component: str) -> None:
    time_s, values = rows(fed.file, f"/FS-20/{entity}", component)
    expected_s, expected = rows(saved, f"/FS-20/{entity}", component)
    np.testing.assert_array_equal(time_s, expected_s)
    np.testing.assert_allclose(np.array(values, dtype=float), np.array(expected, dtype=float))


@pytest.mark.parametrize(
    ("entity", "component"),
    [
        ("elongation/filter", "Measurements:names"),
        ("elongation/filter", "Measurements:colors"),
        ("channels/temperature/2", "SeriesLines:names"),
        ("channels/innovation/1", "SeriesLines:colors"),
        ("profile/band", "LineStrips2D:colors"),
    ],
)
def test_live_looks_are_those_of_a_saved_file(fed: Fed, saved: Path, entity: str, component: str) -> None:
    assert fixed(fed.file, f"/FS-20/{entity}", component) == fixed(saved, f"/FS-20/{entity}", component)


def test_every_view_says_its_unit(fed: Fed) -> None:
    names = view_names(fed.file)
    assert {"Elongation [µm]", "Temperature along the screw [°C over mm]", "Status", "Events"} <= set(names)
    assert all("[" in name for name in names if name not in ("Status", "Events", "State", UNUSED))


def test_the_banner_stands_above_every_page_of_what_is_served(fed: Fed, tmp_path: Path) -> None:
    rec = stream(uuid.uuid4(), tmp_path / "served.rrd")
    begin(rec, blueprint("live", fed.run.rig, frame_of(fed.run.rig), sliding(3600.0), now=True), "served")
    rec.log("live", rr.Scalars(0.0))
    rec.disconnect()
    names = view_names(tmp_path / "served.rrd")
    assert names.count("Now") == 6
    assert {"Error at the table [µm]", "Error at the table over its stroke [µm over mm]"} <= set(names)
    assert "Now" not in view_names(fed.file)


def test_the_closed_file_has_its_footer(fed: Fed) -> None:
    assert RrdReader(fed.file).store()


def test_words_and_status_are_the_callers(fed: Fed) -> None:
    assert rows(fed.file, "/FS-20/events", "TextLog:text")[1] == [["0:00:21  drive starts"]]
    assert rows(fed.file, "/FS-20/status", "TextDocument:text")[1] == [["**at rest**"]]


def test_the_profile_stands_right_in_the_frame_that_holds_then(fed: Fed) -> None:
    """Degrees by the labels of the axis that was logged last before each picture."""
    frames_s, places = rows(fed.file, "/FS-20/profile/axes/y", "Points2D:positions")
    labels = rows(fed.file, "/FS-20/profile/axes/y", "Points2D:labels")[1]
    assert len(frames_s) > 1
    time_s, strips = rows(fed.file, "/FS-20/profile/estimate", "LineStrips2D:strips")
    lift = 0.56 * profile.LINE * (fed.run.rig.screw.to_mm - fed.run.rig.screw.from_mm)
    for when, (mean, *_) in zip(time_s, strips, strict=True):
        i = int(np.searchsorted(frames_s, when, side="right")) - 1
        at = np.array(places[i])[:, 1] + lift
        degrees = [float(label.removesuffix(" °C")) for label in labels[i]]
        drawn = np.polyval(np.polyfit(at, degrees, 1), np.array(mean)[:, 1])
        k = int(np.flatnonzero(fed.run.track.time_s == when)[0])
        np.testing.assert_allclose(drawn, fed.run.track.profile_C[k], atol=1e-3)
        np.testing.assert_allclose(np.array(mean)[:, 0], fed.run.track.x_mm, atol=1e-3)


def test_readings_are_drawn_where_they_speak_for(fed: Fed) -> None:
    """Beyond the estimate that took a part of the innovation in, by the rest of it."""
    time_s, values = rows(fed.file, "/FS-20/elongation/readings", "Scalars:scalars")
    assert 8 < len(time_s) < 60
    at, track = np.searchsorted(fed.run.track.time_s, time_s), fed.run.track
    beyond, innovation = np.ravel(values) - track.elongation_um[at], track.innovation[at, 15]
    assert np.abs(innovation).max() > 0.2
    assert (beyond * np.sign(innovation) > -0.03).all()
    assert (np.abs(beyond) < np.abs(innovation) + 0.03).all()


def test_the_stroke_is_drawn_as_the_filter_says_it(fed: Fed) -> None:
    """Micrometres by the labels of its axis, from one end of the stroke to the other."""
    path, (low, high) = "/FS-20/stroke", fed.run.rig.stroke_mm
    (labels,), (places,) = (rows(fed.file, f"{path}/axes/y", f"Points2D:{what}")[1] for what in ("labels", "positions"))
    _, ((mean, *_),) = rows(fed.file, f"{path}/estimate", "LineStrips2D:strips")
    um = [float(label.removesuffix(" µm")) for label in labels]
    drawn = np.polyval(np.polyfit(np.array(places)[:, 1] + 0.56 * LINE, um, 1), np.array(mean)[:, 1])
    np.testing.assert_allclose(drawn, fed.stroke.error_um[0], atol=1e-3)
    _, (now,) = rows(fed.file, f"{path}/now", "Points2D:positions")
    last = fed.ticks[-1][1]
    share = (now[0][0] - mean[0][0]) / (mean[-1][0] - mean[0][0])
    assert low + share * (high - low) == pytest.approx(last.position_mm, abs=0.01)
    assert np.interp(now[0][0], *np.array(mean).T) == pytest.approx(now[0][1], abs=1.5)


def test_the_error_at_the_table_is_told_over_time_and_as_sent_where_it_was(fed: Fed) -> None:
    time_s, um = rows(fed.file, "/FS-20/table/filter", "Measurements:values")
    track = fed.run.track
    np.testing.assert_allclose(np.ravel(um), track.error_at_table_um[np.searchsorted(track.time_s, time_s)])
    sent_s, sent = rows(fed.file, "/FS-20/table/sent", "Scalars:scalars")
    assert sent_s[0] == WAITING + 1.0
    np.testing.assert_array_equal(sent_s, time_s)  # valid from 2 to 641 s
    np.testing.assert_allclose(np.ravel(sent), np.ravel(um))


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


def test_a_stripe_has_the_colour_of_its_minute(fed: Fed) -> None:
    time_s, colours = rows(fed.file, "/FS-20/residual/open_loop", "SeriesLines:colors")
    begins = np.arange(1.0, SECONDS, 60.0)
    np.testing.assert_allclose(time_s[::2], begins)
    assert (np.diff(time_s) > 0).all()
    assert colours[::2] == colours[1::2]


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


@pytest.mark.parametrize("lane", ["state/drive", "state/mode", "state/thermometers"])
def test_live_states_are_those_of_a_saved_file_at_every_moment(fed: Fed, saved: Path, lane: str) -> None:
    moments = np.arange(SECONDS) + 1.0
    live, afterwards = (state_at(path, f"/FS-20/{lane}", *moments) for path in (fed.file, saved))
    assert live == afterwards
    assert len({*live}) > 1


@pytest.mark.parametrize("lane", ["estimate", "faults/silent"])
def test_live_lanes_are_those_of_a_saved_file(fed: Fed, saved: Path, lane: str) -> None:
    live, afterwards = (rows(path, f"/FS-20/state/{lane}", "StateChange:state") for path in (fed.file, saved))
    np.testing.assert_array_equal(live[0], afterwards[0])
    assert live[1] == afterwards[1]


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


def test_a_broken_thermometer_does_not_stretch_the_frame(fed: Fed, tmp_path: Path) -> None:
    views = LiveViews(fed.run.rig, "FS-20", port=None, save=tmp_path / "x.rrd")
    for sample, step in fed.ticks[:60]:
        measured, fused = step.measured.copy(), step.fused.copy()
        measured[3], fused[3] = 190.0, False
        views.show(sample, replace(step, measured=measured, fused=fused))
    views.close()
    labels = rows(tmp_path / "x.rrd", "/FS-20/profile/axes/y", "Points2D:labels")[1]
    assert "190 °C" not in labels[-1]
    assert views.trouble == ""


@pytest.mark.parametrize(
    "parts", [{"screw", "nut", "supports"}, {"nut"}, {"displacement"}], ids=lambda parts: "+".join(sorted(parts))
)
def test_rigs_that_lack_something_are_shown_all_the_same(fed: Fed, tmp_path: Path, parts: set[str]) -> None:
    rig, gone = fed.run.rig, {"screw": None, "nut": None, "supports": {}}
    rig = replace(rig, **{part: gone[part] for part in parts & gone.keys()})
    ticks = fed.ticks[:130]
    if "displacement" in parts:
        rig = replace(rig, channels={name: c for name, c in rig.channels.items() if name != "displacement"})
        ticks = [(replace(sample, channels=sample.channels[:-1]), shorter(step)) for sample, step in ticks]
    if "screw" in parts:
        none = {"profile_C": np.empty(0), "profile_sd_K": np.empty(0), "elongation_um": np.nan, "open_loop_um": np.nan}
        ticks = [(sample, replace(step, **none)) for sample, step in ticks]
    views = LiveViews(rig, "bare", port=0, save=tmp_path / "bare.rrd")
    show(views, ticks)
    views.close()
    assert views.trouble == ""
    names = view_names(tmp_path / "bare.rrd")
    assert any("Temperature along" in name for name in names) == ("screw" not in parts)
    assert any("over its stroke" in name for name in names) == ("nut" not in parts)
    assert any("displacement" in name.lower() for name in names) == ("displacement" not in parts)
    modes = {state for (state,) in rows(tmp_path / "bare.rrd", "/bare/state/mode", "StateChange:state")[1]}
    assert ("predict" in modes) == ("displacement" in parts)
    assert len(rows(tmp_path / "bare.rrd", "/bare/channels/temperature/1", "Scalars:scalars")[0]) == 130


def test_a_rig_on_which_nothing_moves_has_no_lane_of_driving(fed: Fed, tmp_path: Path) -> None:
    rig = replace(fed.run.rig, nut=None, inputs={})
    views = LiveViews(rig, "still", port=None, save=tmp_path / "still.rrd")
    show(views, fed.ticks[:60])
    views.close()
    lanes = {str(chunk.entity_path) for chunk in RrdReader(tmp_path / "still.rrd").stream().to_chunks()}
    assert "/still/state/mode" in lanes
    assert "/still/state/drive" not in lanes


def shorter(step: Step) -> Step:
    """A step without its last channel."""
    per_channel = ("names", "measured", "predicted", "innovation", "innovation_sd", "fused", "why", "open_loop")
    per_channel += ("fault", "since_s", "may_drift_K", "jump")
    mode = Mode.PREDICT if step.mode == Mode.UPDATE else step.mode
    return replace(step, mode=mode, **{name: getattr(step, name)[:-1] for name in per_channel})


def test_nothing_but_ticks_before_the_start_is_fine(fed: Fed, tmp_path: Path) -> None:
    assert {step.mode for _, step in fed.ticks[:WAITING]} == {Mode.INIT}
    views = LiveViews(fed.run.rig, "early", port=0, save=tmp_path / "early.rrd")
    show(views, fed.ticks[:WAITING], 1)
    views.close()
    assert views.trouble == ""
    chunks = RrdReader(tmp_path / "early.rrd").stream().to_chunks()
    assert all(chunk.to_record_batch().num_rows for chunk in chunks)  # the viewer panics at a chunk without rows


# --- ranges


def test_a_range_grows_ahead_of_its_values_and_seldom() -> None:
    growing, found = Growing(5.0), set()
    for value in np.linspace(20.0, 60.0, 400):
        low, high = growing.hold([np.array([20.0, value, np.nan])])
        assert low <= 20.0
        assert high >= value
        found.add((low, high))
    assert len(found) < 15
    assert high - low < 1.5 * 40.0
    assert Growing(5.0).hold([np.array([np.nan])]) is None


def test_colours_of_a_map_show_small_and_large_alike() -> None:
    scale = Decades.of(np.full((10, 3), 0.03))
    assert scale.finest == pytest.approx(0.005)
    np.testing.assert_allclose(scale.shares(np.array([0.004, 0.05, -0.5, np.nan])), [0.0, 0.5, -1.0, np.nan])
    assert scale.labels("K") == ["-0.5 K", "-0.05 K", "±0.005 K", "+0.05 K", "+0.5 K"]


def test_what_seldom_changes_is_repeated() -> None:
    seldom = Repeated[str](600.0)
    assert [seldom.due(*each) for each in (("a", 0.0), ("a", 599.0), ("b", 599.5), ("b", 1199.0), ("b", 1199.5))] == [
        True, False, True, False, True,
    ]  # fmt: skip


# --- who can reach it


def listening(port: int) -> set[str]:
    """Addresses at which this machine listens on a port, as the kernel writes them."""
    lines = [line.split() for name in ("tcp", "tcp6") for line in Path(f"/proc/net/{name}").read_text().splitlines()]
    return {cells[1].split(":")[0] for cells in lines if cells[1].endswith(f":{port:04X}") and cells[3] == "0A"}


@LINUX
def test_stream_and_page_are_served_on_the_loopback_only(rig: Rig) -> None:
    with served(rig) as views:
        page = WebPage(views.url)
        ports = [urlsplit(address).port for address in (views.url.removeprefix("rerun+"), page.address)]
        assert [listening(port) for port in ports] == [{"0100007F"}] * 2
        page.close()
        assert listening(ports[1]) == set()
    until(lambda: not listening(ports[0]))  # the server lets go of it in its own time


@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_a_late_viewer_gets_it_all(fed: Fed, tmp_path: Path) -> None:
    got = tmp_path / "got.rrd"

    def seen() -> list[float]:
        try:
            chunks = RrdReader(got).stream().filter(content="/live/channels/innovation/1").to_chunks()
        except (ValueError, RuntimeError):  # not there yet, or in the middle of being written
            return []
        batches = [chunk.to_record_batch() for chunk in chunks if not chunk.is_static]
        return [t / 1e9 for batch in batches for t in batch.column("time").cast("int64").to_pylist()]

    with served(fed.run.rig) as views:
        show(views, fed.ticks[:100])
        late = viewer.start([views.url, "--save", str(got)], free_port())
        try:
            until(lambda: len(seen()) == 100)
        finally:
            late.terminate()
            late.wait(PATIENCE_S)
        show(views, fed.ticks[100:200])
        assert views.trouble == ""
    np.testing.assert_array_equal(sorted(seen()), fed.run.track.time_s[:100])


@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_a_run_that_begins_anew_is_a_recording_of_its_own(fed: Fed, tmp_path: Path) -> None:
    got = tmp_path / "got.rrd"

    def seen() -> list[int]:
        """Ticks of each recording."""
        try:
            reader = RrdReader(got)
            streams = [reader.stream(store=each) for each in reader.recordings()]
            found = [each.filter(content="/live/channels/innovation/1").to_chunks() for each in streams]
            return [sum(chunk.num_rows for chunk in chunks if not chunk.is_static) for chunks in found]
        except (ValueError, RuntimeError):
            return []

    with served(fed.run.rig) as views:
        looks_on = viewer.start([views.url, "--save", str(got)], free_port())
        try:
            show(views, fed.ticks[:100])
            views.begin()
            show(views, fed.ticks[:50])
            until(lambda: sorted(seen()) == [50, 100])
        finally:
            looks_on.terminate()
            looks_on.wait(PATIENCE_S)
        assert views.trouble == ""


@pytest.mark.parametrize(("site", "allowed"), [("http://127.0.0.1:1234", True), ("http://evil.example", False)])
def test_scripts_of_other_sites_may_not_read_the_stream(rig: Rig, site: str, allowed: bool) -> None:
    with served(rig) as views:
        address = views.url.removeprefix("rerun+").replace("/proxy", "/rerun.sdk_comms.v1alpha1.MessageProxyService/x")
        headers = {"Origin": site, "Access-Control-Request-Method": "POST"}
        request = urllib.request.Request(address, headers=headers, method="OPTIONS")
        direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        with direct.open(request, timeout=PATIENCE_S) as answer:
            assert (answer.headers["Access-Control-Allow-Origin"] is not None) == allowed


def test_the_server_forgets_beyond_its_limit(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[str, Any] = {}
    sink = rr.GrpcServerSink

    def spy(bind: str, port: int, **how: Any) -> Any:
        asked.update(how, bind=bind)
        return sink(bind, port, **how)

    monkeypatch.setattr(rr, "GrpcServerSink", spy)
    with served(rig, memory="16MiB"):
        assert (asked["server_memory_limit"], asked["bind"]) == ("16MiB", "127.0.0.1")


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"bind": "0.0.0.0"}, "bind 0.0.0.0: not one address"),
        ({"bind": "localhost"}, "bind localhost: not an IPv4 address"),
        ({"bind": "300.1.1.1"}, "bind 300.1.1.1: not an IPv4 address"),
        ({"bind": "192.0.2.1"}, "192.0.2.1:0: cannot listen there"),
        ({"port": 70000}, "port 70000: not between"),
        ({"memory": "much"}, "memory limit much"),
        ({"window_s": 0.0}, "window of 0 s"),
    ],
)
def test_what_cannot_be_served_is_said_in_a_line(rig: Rig, how: dict[str, Any], said: str) -> None:
    with pytest.raises(SetupError, match=said) as error:
        LiveViews(rig, "live", **{"port": 0, **how})
    assert "\n" not in str(error.value)


def test_a_taken_port_is_said_before_anything_starts(rig: Rig, tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with pytest.raises(SetupError, match=rf"127.0.0.1:{port}: cannot listen there .*; choose another port"):
            LiveViews(rig, "live", port=port, save=tmp_path / "x.rrd")
        with pytest.raises(SetupError, match=rf"127.0.0.1:{port}: cannot listen"):
            WebPage("rerun+http://127.0.0.1:9/proxy", port=port)
    assert not (tmp_path / "x.rrd").exists()


@pytest.mark.parametrize("name", ["nowhere/x.rrd", "."])
def test_a_file_that_cannot_be_written_is_said(rig: Rig, tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"there is no folder|cannot be written"):
        LiveViews(rig, "live", port=0, save=tmp_path / name)


# --- that it stops nobody


def test_a_full_disk_is_told_and_the_file_goes_on_when_there_is_room(
    fed: Fed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "x.rrd"
    with served(fed.run.rig, port=None, save=file) as views:
        monkeypatch.setattr(live, "RESERVE", 1 << 62)
        show(views, fed.ticks[:100])
        assert "x.rrd: nothing gets out, ticks wait (the disk is nearly full" in views.trouble
        monkeypatch.undo()
        views.flush()
        assert views.trouble == ""
    assert len(rows(file, "/live/channels/innovation/1", "Scalars:scalars")[0]) == 100


def test_ticks_wait_while_a_viewer_hangs(fed: Fed, monkeypatch: pytest.MonkeyPatch) -> None:
    def hangs(*_: Any, **__: Any) -> None:
        raise RuntimeError("Flush timed out")

    with served(fed.run.rig) as views:
        monkeypatch.setattr(rr.RecordingStream, "flush", hangs)
        show(views, fed.ticks[:100], 20)
        assert "nothing gets out, ticks wait (Flush timed out)" in views.trouble
        monkeypatch.undo()
        views.flush()
        assert views.trouble == ""


def test_a_view_that_breaks_is_counted(fed: Fed, monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks(*_: Any) -> None:
        raise ValueError("no such colour")

    with served(fed.run.rig) as views:
        monkeypatch.setattr(Rows, "send", breaks)
        show(views, fed.ticks[:40], 20)
        assert "2 batches failed, the last one: ValueError: no such colour" in views.trouble
        show(views, fed.ticks[40:200], 20)
        assert "10 or more batches failed" in views.trouble


def test_too_many_ticks_are_given_up_and_counted(fed: Fed, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outlet, "WAITING", 30)
    with served(fed.run.rig, port=None, save=Path("/dev/null")) as views:
        for sample, step in fed.ticks[:100]:
            views.show(sample, step)
        assert "50 or more ticks were given up" in views.trouble


# --- in a viewer


@LINUX
def test_no_viewer_follows_without_a_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert viewer.follow("rerun+http://127.0.0.1:9/proxy") is None


def test_a_viewer_follows_with_limited_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    url, started = "rerun+http://127.0.0.1:9/proxy", []
    monkeypatch.setattr(viewer, "has_screen", lambda: True)
    monkeypatch.setattr(viewer, "start", lambda arguments, port: started.append(arguments))
    viewer.follow(url)
    assert started == [["--memory-limit", viewer.MEMORY, "--connect", url]]
