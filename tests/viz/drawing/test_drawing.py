"""The small parts of the views: ranges, colours, windows, pages, the viewer's surroundings."""

import sys
from pathlib import Path

import numpy as np
import pytest

from estimator.errors import SetupError
from tests.viz_fake import fake_run
from tests.viz_read import has_no_empty_chunk
from viz.drawing.frames import Axes
from viz.drawing.profile import picture_ticks
from viz.drawing.residuals import consistency, whiteness
from viz.drawing.scale import DIVERGING, clock, coloured, minutes, rounded, symmetric, ticks_of, widened
from viz.drawing.series import spaced
from viz.recorded.recorded import save
from viz.viewer import pages, pictures, viewer


def test_ranges_are_rounded_outwards_to_ticks() -> None:
    assert rounded((-0.3, 52.1)) == (-5.0, 55.0)
    assert rounded((3.0, 3.0))[1] > 3.0
    assert widened((22.0, 22.1), 1.0) == pytest.approx((21.55, 22.55))
    np.testing.assert_allclose(ticks_of((-5.0, 55.0), 7), [0, 10, 20, 30, 40, 50])


def test_symmetric_range_forgives_single_spikes() -> None:
    assert symmetric(np.array([*np.full(999, 0.04), 30.0])) == (-0.05, 0.05)


def test_zero_is_dark_and_the_ends_are_bright() -> None:
    low, zero, high = coloured([-9.0, 0.0, 9.0], (-1.0, 1.0), DIVERGING)[:, :3]
    assert tuple(zero) == DIVERGING[2]
    assert tuple(low) == DIVERGING[0]
    assert tuple(high) == DIVERGING[-1]


def test_minutes_average_what_is_known() -> None:
    time_s = np.arange(120.0)
    values = np.stack([time_s, np.full(120, np.nan)], axis=-1)
    begins, means = minutes(time_s, values)
    np.testing.assert_allclose(begins, [0, 60])
    np.testing.assert_allclose(means[:, 0], [29.5, 89.5])
    assert np.isnan(means[:, 1]).all()


def test_white_innovations_pass_their_tests() -> None:
    dice = np.random.default_rng(0)
    time_s, sd = np.arange(60_000.0), np.full((60_000, 2), 0.3)
    innovation = dice.normal(0, sd)
    white = whiteness(time_s, innovation, sd)[1]
    assert np.abs(white).std() < 1.0
    assert white.std() == pytest.approx(1.0, abs=0.05)
    nis = ((innovation / sd) ** 2).sum(axis=1)
    _, ratio, bounds = consistency(time_s, nis, np.full(60_000, 2))
    inside = (ratio > bounds.min(axis=1)) & (ratio < bounds.max(axis=1))
    assert inside.mean() == pytest.approx(0.95, abs=0.02)


def test_points_are_spaced_by_what_is_seen() -> None:
    time_s, values = np.arange(1000.0), np.linspace(0, 1, 1000)
    values[5] = np.nan
    shown = spaced(time_s, values, (0, 1000), (0, 1))
    assert 23 <= len(shown) <= 26
    assert 5 not in shown


def test_pictures_are_taken_every_ten_seconds_once_there_is_a_profile() -> None:
    profile = np.ones((40, 3))
    profile[:4] = np.nan
    np.testing.assert_array_equal(picture_ticks(np.arange(40.0), profile), [4, 10, 20, 30])


def test_frame_turns_y_over() -> None:
    axes = Axes((0, 100), (20, 30), 100.0, 50.0, 5.0)
    np.testing.assert_allclose(axes.place([0, 100], [20, 30]), [[0, -100], [100, -150]])


def test_clock() -> None:
    assert clock(3982.4) == "1:06:22"


def test_pages_are_the_innermost_tabs() -> None:
    def box(kind: str, name: str, *contents: str) -> dict:
        return {"ContainerBlueprint": {"container_kind": kind, "display_name": name, "contents": list(contents)}}

    layout = {
        "/viewport": {"ViewportBlueprint": {"root_container": "r"}},
        "/container/r": box("Tabs", "", "container/a", "container/b"),
        "/container/a": box("Horizontal", "Summary", "view/1"),
        "/container/b": box("Tabs", "FS-20", "container/c"),
        "/container/c": box("Vertical", "Overview", "view/2"),
        "/view/1": {"ViewBlueprint": {"display_name": "Text"}},
        "/view/2": {"ViewBlueprint": {"display_name": "Elongation"}},
    }
    summary, overview = pages.pages_of(layout)
    assert summary.names == ("Summary",)
    assert overview.names == ("FS-20", "Overview")
    overview.show(layout)
    assert layout["/container/r"]["ContainerBlueprint"]["active_tab"] == "container/b"


def test_pictures_of_no_file_are_an_error_of_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert pictures.main([str(tmp_path / "no.rrd"), str(tmp_path)]) == SetupError.exit_code
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is always a screen")
def test_no_viewer_without_a_screen(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert not viewer.open_viewer(tmp_path / "x.rrd")


def test_the_viewer_that_came_with_the_package_is_there() -> None:
    assert viewer.executable().is_file()


def test_no_chunk_is_empty(tmp_path: Path) -> None:
    """One tick leaves nothing to say in several views."""
    save(tmp_path / "short.rrd", [fake_run("short", 1)], "")
    assert has_no_empty_chunk(tmp_path / "short.rrd")
