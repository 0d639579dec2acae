"""Live views show what a file keeps that is saved afterwards."""

import uuid
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from tests.viz.live.conftest import SECONDS, WAITING, Fed
from tests.viz_read import fixed, rows, state_at, view_names
from viz.drawing import profile
from viz.drawing.file import begin, stream
from viz.drawing.views import sliding
from viz.live.body import frame_of
from viz.live.layout import blueprint
from viz.live.table import LINE

UNUSED = "Channels that are not used all the time"


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
    assert (beyond * np.sign(innovation) > -0.2 * track.sigma_um[at]).all()
    assert (np.abs(beyond) < np.abs(innovation) + 0.2 * track.sigma_um[at]).all()


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


def test_a_stripe_has_the_colour_of_its_minute(fed: Fed) -> None:
    time_s, colours = rows(fed.file, "/FS-20/residual/open_loop", "SeriesLines:colors")
    begins = np.arange(1.0, SECONDS, 60.0)
    np.testing.assert_allclose(time_s[::2], begins)
    assert (np.diff(time_s) > 0).all()
    assert colours[::2] == colours[1::2]


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
