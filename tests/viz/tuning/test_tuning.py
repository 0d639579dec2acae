"""What is in the views of a tuning: read back with the reader of the format, no viewer needed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.viz_read import fixed, has_no_empty_chunk, pixels, rows, view_names
from viz.drawing import paths
from viz.drawing.bars import BarSeries, NisBars
from viz.drawing.file import opens_at
from viz.drawing.frames import ROW, WIDTH
from viz.drawing.scale import DIVERGING, UNKNOWN
from viz.tuning.tuning import ScaledInnovations, Tuning, save, shades_of

CHANNELS = ("T01", "T 2", "T03", "T04", "displacement")
SECONDS = 400


def side(seed: int, size: float) -> ScaledInnovations:
    """White innovations `size` times as large as they should be; the last channel is read every third second."""
    scaled = size * np.random.default_rng(seed).standard_normal((SECONDS, 5))
    scaled[np.arange(SECONDS) % 3 > 0, 4] = np.nan
    autocorrelation = np.full((5, 61), 0.01)
    autocorrelation[:, 0], autocorrelation[1, 5], autocorrelation[4, 7] = 1.0, -0.5 * size, np.nan
    return ScaledInnovations(scaled, autocorrelation)


def tuning(name: str = "FS-20") -> Tuning:
    return Tuning(name, np.arange(SECONDS) + 2.0, np.arange(61.0), {"before": side(0, 2.0), "after": side(1, 1.0)})


def ratios(before: list[float], after: list[float]) -> NisBars:
    both = BarSeries("before", np.array(before), paths.BEFORE), BarSeries("after", np.array(after), paths.AFTER)
    return NisBars("NIS a tick ahead [1]", CHANNELS[: len(before)], both)


NIS = ratios([4.0, 0.25, 1.0, 2.0, np.nan], [1.0, 0.9, 1.1, 1.0, np.nan])


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two recordings in one file."""
    path = tmp_path_factory.mktemp("viz") / "two.rrd"
    save(path, CHANNELS, [tuning(), tuning("CS 2.5")], [NIS, replace(NIS, title="NIS, blind [1]")], "# By the caller")
    return path


@pytest.mark.parametrize("name", ["before", "after"])
def test_innovations_are_the_callers(saved: Path, name: str) -> None:
    scaled = tuning().sides[name].scaled
    time_s, values = rows(saved, f"/FS-20/scaled/{name}/T_2/each", "Scalars:scalars")
    np.testing.assert_allclose(time_s, tuning().time_s)
    np.testing.assert_allclose(np.ravel(values), scaled[:, 1])
    time_s, values = rows(saved, f"/CS_2.5/scaled/{name}/displacement/each", "Scalars:scalars")
    assert len(time_s) == 134
    np.testing.assert_allclose(np.ravel(values), scaled[::3, 4])


def test_each_channel_has_its_lines_and_minute_means(saved: Path) -> None:
    ends, bounds = rows(saved, "/FS-20/scaled/after/T01/bounds", "Scalars:scalars")
    assert (ends.tolist(), bounds) == ([2.0, 401.0], [[2.0, -2.0]] * 2)
    middles, means = rows(saved, "/FS-20/scaled/after/T01/mean", "Scalars:scalars")
    assert middles[0] == 32.0
    assert means[0][0] == pytest.approx(tuning().sides["after"].scaled[:60, 0].mean())


def test_before_and_after_have_their_own_colours(saved: Path) -> None:
    first, second = (fixed(saved, f"/FS-20/scaled/{n}/T01/each", "SeriesPoints:colors")[0] for n in ("before", "after"))
    assert [first >> 24, first >> 16 & 255, first >> 8 & 255] == [*paths.BEFORE]
    assert [second >> 24, second >> 16 & 255, second >> 8 & 255] == [*paths.AFTER]


def test_the_map_has_a_row_for_each_channel_and_a_column_for_each_lag(saved: Path) -> None:
    drawn = pixels(saved, "/FS-20/autocorrelation/before/picture")
    assert drawn.shape == (5, 61, 3)
    assert {tuple(cell) for cell in drawn[:, 0]} == {DIVERGING[-1]}
    assert tuple(drawn[1, 5]) == DIVERGING[0]
    assert tuple(drawn[4, 7]) == UNKNOWN
    assert fixed(saved, "/FS-20/autocorrelation/before/channels", "Points2D:labels") == [*CHANNELS]
    places = np.array(fixed(saved, "/FS-20/autocorrelation/before/x", "Points2D:positions"))
    labels = fixed(saved, "/FS-20/autocorrelation/before/x", "Points2D:labels")
    wide = fixed(saved, "/FS-20/autocorrelation/before/picture", "Transform3D:scale")[0][0]
    np.testing.assert_allclose(places[:, 0], wide * (np.array(labels, dtype=float) + 0.5), rtol=1e-5)


def test_colours_reach_to_what_is_no_chance() -> None:
    assert shades_of(side(0, 0.0).autocorrelation) == (-0.2, 0.2)
    strong = np.full((5, 61), 0.45)
    assert shades_of(strong) == (-0.5, 0.5)


def test_bars_go_from_one_to_nis(saved: Path) -> None:
    drawn = pixels(saved, "/bars/0/picture")
    assert NIS.ticks.tolist() == [0.2, 0.5, 1, 2, 5]
    per_log = WIDTH / np.log(5 / 0.2)
    for row, value in enumerate([4.0, 0.25, 1.0, 2.0]):
        orange = np.flatnonzero((drawn[row * ROW + 10] == paths.BEFORE).all(axis=-1))
        ends = sorted([np.log(1 / 0.2) * per_log, np.log(value / 0.2) * per_log])
        assert [orange[0], orange[-1]] == pytest.approx(ends, abs=1.0)
    blue = np.flatnonzero((drawn[1 * ROW + 30] == paths.AFTER).all(axis=-1))
    assert len(blue) == pytest.approx(-np.log(0.9) * per_log, abs=2.0)
    assert (drawn[4 * ROW :] == paths.BACKGROUND).all()


def test_values_stand_beside_their_bars_and_inside_the_view(saved: Path) -> None:
    labels = fixed(saved, "/bars/0/values", "Points2D:labels")
    assert labels == ["4.000 / 1.000", "0.250 / 0.900", "1.000 / 1.100", "2.000 / 1.000"]
    x = np.array(fixed(saved, "/bars/0/values", "Points2D:positions"))[:, 0]
    half = 5.0 * len(labels[0])
    assert (x - half > NIS.width).all()  # beyond every bar
    assert (x + half).max() < NIS.frame.bounds[0][1]


def test_bars_of_nothing_and_of_too_much_still_have_a_scale() -> None:
    nothing = [np.nan] * 3
    assert ratios(nothing, nothing).ticks.tolist() == [0.5, 1, 2]
    assert ratios([0.0], [1e9]).ticks[[0, -1]] == pytest.approx([1e-3, 5e3])


def test_views_stand_side_by_side_and_say_what_they_show(saved: Path) -> None:
    names = view_names(saved)
    assert len(names) == 3 + 2 * (2 + 2 * 5)
    assert "T 2 before: innovation over its sd [1], with ±2 and the mean of each minute" in names
    assert "Autocorrelation of the innovations after [1]" in names
    assert all("[1]" in name for name in names if name != "Summary")


def test_summary_is_the_callers_and_the_end_is_the_moment(saved: Path) -> None:
    assert fixed(saved, "/summary", "TextDocument:text") == ["# By the caller"]
    assert opens_at(saved) == 401.0


def test_a_silent_channel_and_a_single_tick_leave_no_empty_chunk(tmp_path: Path) -> None:
    nothing = ScaledInnovations(np.full((1, 5), np.nan), np.full((5, 13), np.nan))
    short = Tuning("short", np.array([5.0]), 5.0 * np.arange(13), {"before": nothing, "after": nothing})
    save(tmp_path / "short.rrd", CHANNELS, [short], [NIS], "")
    assert has_no_empty_chunk(tmp_path / "short.rrd")
    assert len(view_names(tmp_path / "short.rrd")) == 2 + 2 + 2 * 5
