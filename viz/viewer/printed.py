"""Pictures of one or two models for a report, as PNG files: bars of errors, and maps on one scale of colours."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viz.comparison.compared import ComparedRun
from viz.comparison.layout import titles
from viz.comparison.maps import BROUGHT, HEAT, TITLES, UNITS, Map, brings, map_of, scales_of
from viz.drawing import paths
from viz.drawing.bars import Bars
from viz.drawing.scale import DIVERGING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DOTS = 120  # per inch
INCHES = 6.4  # width of one map
ROW_INCHES = 0.15
FAINT = 0.03  # of the range of colours: not to be told from nothing
SHORT_MIN = 15.0  # no map of heat is cut shorter
SHADES = 257  # an odd number: one of them is zero


def print_bars(path: Path, figures: Sequence[Bars]) -> None:
    """Figures side by side."""
    rows = max(len(each.rows) for each in figures)
    with _sheet(path, INCHES * len(figures), 1.1 + 0.42 * rows) as sheet:
        for bars, axes in zip(figures, np.ravel(sheet.subplots(1, len(figures), squeeze=False)), strict=True):
            _bars(axes, bars)


def print_maps(path: Path, runs: Sequence[ComparedRun], models: Sequence[str], what: str) -> None:
    """A row for each run; a column for each model, and beside heat missing one for what added effects bring."""
    maps = [[map_of(run, side, what) for side in run.sides] for run in runs]
    columns = [*titles(models).values()]
    if what == HEAT and (said := max(map(brings, runs), key=len)):  # in some run it may bring nothing
        maps = [[*row, map_of(run, run.sides[-1], BROUGHT)] for run, row in zip(runs, maps, strict=True)]
        columns.append(said)
    extent, rows = scales_of(runs)[what], len(maps[0][0].rows)
    with _sheet(path, INCHES * len(columns) + 0.8, 0.9 + len(runs) * (0.55 + ROW_INCHES * rows)) as sheet:
        grid = sheet.subplots(len(runs), len(columns), squeeze=False, sharex="row", sharey=True)
        for run, row, found in zip(runs, grid, maps, strict=True):
            for axes, title, one in zip(row, columns, found, strict=True):
                axes.set_title(f"{run.name}, {title}", fontsize=9)
                drawn = _map(axes, one, extent)
            if what == HEAT:
                row[0].set_xlim(0.0, _until(found, extent))
        for axes in grid[-1]:
            axes.set_xlabel("time [min]")
        sheet.suptitle(TITLES[what])
        sheet.colorbar(drawn, ax=grid, fraction=0.04, aspect=30).set_label(f"[{UNITS[what]}]")


@contextmanager
def _sheet(path: Path, width: float, height: float) -> Iterator[Figure]:
    """An empty figure in the colours of the views, written at the end."""
    import matplotlib  # takes a third of a second
    from matplotlib.figure import Figure

    ink, paper = _part(paths.TEXT), _part(paths.BACKGROUND)
    inked = ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")
    papered = ("figure.facecolor", "axes.facecolor", "savefig.facecolor", "legend.facecolor")
    with matplotlib.rc_context({**dict.fromkeys(inked, ink), **dict.fromkeys(papered, paper)}):
        sheet = Figure((width, height), layout="constrained")
        yield sheet
        sheet.savefig(path, dpi=DOTS)


def _bars(axes: Axes, bars: Bars) -> None:
    height = 0.8 / len(bars.series)
    for i, each in enumerate(bars.series):
        at = np.arange(len(bars.rows)) + (i + 0.5) * height - 0.4
        drawn = axes.barh(at, np.nan_to_num(each.values), height * 0.92, color=_part(each.colour), label=each.name)
        texts = [f"{value:.3f}" if np.isfinite(value) else "" for value in each.values]
        axes.bar_label(drawn, texts, padding=3, fontsize=8)
    axes.set_yticks(np.arange(len(bars.rows)), bars.rows)
    axes.invert_yaxis()
    axes.set_xlim(0.0, bars.end)
    axes.set_xlabel(bars.title)
    axes.legend(loc="lower right", fontsize=8)


def _until(found: Sequence[Map], extent: tuple[float, float]) -> float:
    """Minutes after which none of a run's maps shows anything to speak of, and a third more."""
    seen = [np.flatnonzero((np.abs(one.values) > FAINT * extent[1]).any(axis=1)) for one in found]
    last = max((minute[-1] + 1 for minute in seen if len(minute)), default=0)
    return float(min(max(4 * last / 3, SHORT_MIN), len(found[0].begins_s)))


def _map(axes: Axes, found: Map, extent: tuple[float, float]) -> Any:
    from matplotlib.colors import LinearSegmentedColormap

    colours = LinearSegmentedColormap.from_list("diverging", [_part(colour) for colour in DIVERGING], SHADES)
    end = float(len(found.begins_s))
    box = (0.0, end, len(found.rows) - 0.5, -0.5)
    drawn = axes.imshow(
        np.ma.masked_invalid(found.values.T), colours, aspect="auto", interpolation="nearest", extent=box,
        vmin=extent[0], vmax=extent[1],
    )  # fmt: skip
    axes.set_yticks(np.arange(len(found.rows)), found.rows, fontsize=6)
    return drawn


def _part(colour: Sequence[int]) -> tuple[float, ...]:
    return tuple(part / 255 for part in colour)
