"""Every axis has labels, every legend its names, and no label hides another, in three sizes of window."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import rerun.blueprint as rrb

from estimator.rig import Rig
from tests import viz_layout
from tests.viz.comparison.test_comparison import ERRORS, compared
from tests.viz.tuning.test_tuning import CHANNELS, NIS, tuning
from tests.viz_fake import fake_run
from viz.comparison import comparison, maps
from viz.recorded import layout as recorded_layout, recorded
from viz.tuning import tuning as tuning_views, tuning as tunings

WINDOWS = (1280, 800), (1366, 768), (1920, 1080)
HIDDEN = 0.35  # of a label that another may cover: its letters are still all there
Case = tuple[Path, rrb.Blueprint]


@pytest.fixture(scope="module")
def cases(rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Case]:
    """A file of each kind with its layout."""
    folder = tmp_path_factory.mktemp("layout")
    run, pair, figures = fake_run("FS-20", 700), compared(rig), {"Errors": [ERRORS], "Channels": [ERRORS]}
    recorded.save(folder / "recorded.rrd", [run], "")
    comparison.save(folder / "comparison.rrd", [pair], ("a.toml", "b.toml"), figures, "")
    tunings.save(folder / "tuning.rrd", CHANNELS, [tuning()], [NIS], "")
    scales = maps.scales_of([pair])
    layouts = {
        "recorded": recorded_layout.blueprint([run]),
        "comparison": comparison.blueprint([pair], ("a.toml", "b.toml"), figures, scales),
        "tuning": tuning_views.blueprint(CHANNELS, [tuning()], [NIS]),
    }
    return {name: (folder / f"{name}.rrd", layout) for name, layout in layouts.items()}


@pytest.mark.parametrize("kind", ["recorded", "comparison", "tuning"])
@pytest.mark.parametrize("window", WINDOWS, ids=str)
def test_axes_have_two_labels_and_legends_all_names(cases: dict[str, Case], kind: str, window: tuple[int, int]) -> None:
    path, layout = cases[kind]
    plots = [one for one in viz_layout.placed(layout, window) if isinstance(one.view, rrb.TimeSeriesView)]
    assert plots
    for one in plots:
        high, said = one.height - viz_layout.TIMES, f"{one.page}: {one.view.name}"
        extent = one.property("ScalarAxis", "range")
        assert extent is not None, said
        tens = 10.0 ** np.arange(-6, 6)
        assert viz_layout.labels_of_axis(extent, high, tens, viz_layout.APART_Y) >= 2, f"{said}: {extent}"
        times = one.property("TimeAxis", "view_range")
        seconds = [times[end] / 1e9 for end in ("start", "end")]
        steps = viz_layout.TIME_STEPS
        assert viz_layout.labels_of_axis(seconds, one.width, steps, viz_layout.APART_X) >= 2, f"{said}: {seconds}"
        if one.property("PlotLegend", "visible"):
            room = (viz_layout.MOST * high - viz_layout.AROUND) / viz_layout.ENTRY
            assert viz_layout.entries(path, one.view.origin) <= room, said


@pytest.mark.parametrize("kind", ["recorded", "comparison", "tuning"])
@pytest.mark.parametrize("window", WINDOWS, ids=str)
def test_no_label_of_a_figure_hides_another_or_is_cut(
    cases: dict[str, Case], kind: str, window: tuple[int, int]
) -> None:
    path, layout = cases[kind]
    figures = [one for one in viz_layout.placed(layout, window) if isinstance(one.view, rrb.Spatial2DView)]
    assert figures
    for one in figures:
        said, found = f"{one.page}: {one.view.name}", viz_layout.labels(path, one.view.origin, one)
        for text, box in found:
            assert (box > -6.0).all(), f"{said}: {text}"
            assert (box[2:] < [one.width + 6.0, one.height + 6.0]).all(), f"{said}: {text}"
        for (text, box), (other, its) in combinations(found, 2):
            assert viz_layout.covered(box, its) < HIDDEN, f"{said}: {text} and {other}"
