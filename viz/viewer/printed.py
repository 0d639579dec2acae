"""Pictures of one or two models for a report, as PNG files: bars of errors, and maps on one scale of colours."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from estimator.record import Array
from viz.comparison.compared import ComparedRun
from viz.comparison.comparison import titles
from viz.comparison.heat import curves, frame_of
from viz.comparison.maps import BROUGHT, HEAT, OPEN_LOOP, SAID, UNITS, brings, map_of, scales_of
from viz.drawing import paths
from viz.drawing.bars import Bars
from viz.drawing.profile import bearings_mm
from viz.drawing.scale import DIVERGING, Range
from viz.figures.map import Map

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import RcKeyType

DOTS = 120  # per inch
INCHES = 6.4  # width of one map
ROW_INCHES = 0.15
SHADES = 257  # an odd number: one of them is zero


def print_bars(path: Path, figures: Sequence[Bars]) -> None:
    """Figures side by side."""
    rows = max(len(each.rows) for each in figures)
    with _sheet(path, INCHES * len(figures), 1.1 + 0.42 * rows) as sheet:
        for bars, axes in zip(figures, np.ravel(sheet.subplots(1, len(figures), squeeze=False)), strict=True):
            _bars(axes, bars)


def print_maps(path: Path, runs: Sequence[ComparedRun], models: Sequence[str]) -> None:
    """What thermometers show beside the models alone: a row for each run, a column for each model."""
    columns, extent = [*titles(models).values()], scales_of(runs)[OPEN_LOOP]
    maps = [[map_of(run, side, OPEN_LOOP) for side in run.sides] for run in runs]
    with _rows(path, runs, maps, len(columns)) as (sheet, grid):
        for run, row, found in zip(runs, grid, maps, strict=True):
            drawn = _titled(row, run, columns, found, extent)
        sheet.suptitle(SAID[OPEN_LOOP])
        sheet.colorbar(drawn, ax=grid, fraction=0.04, aspect=30).set_label(f"[{UNITS[OPEN_LOOP]}]")


def print_heat(path: Path, runs: Sequence[ComparedRun], models: Sequence[str]) -> None:
    """Heat missing: over the screw while driving and at rest, then as maps, and what added effects bring."""
    maps = [[map_of(run, side, HEAT) for side in run.sides] for run in runs]
    columns, extent = [*titles(models).values()], scales_of(runs)[HEAT]
    if said := max(map(brings, runs), key=len):  # in some run it may bring nothing
        maps = [[*row, map_of(run, run.sides[-1], BROUGHT)] for run, row in zip(runs, maps, strict=True)]
        columns.append(said)
    does = list(dict.fromkeys(name for run in runs for name in curves(run)))
    with _rows(path, runs, maps, len(does) + len(columns)) as (sheet, grid):
        for run, row, found in zip(runs, grid, maps, strict=True):
            for axes, name in zip(row, does, strict=False):
                _along(axes, run, name)
            drawn = _titled(row[len(does) :], run, columns, found, extent)
        sheet.suptitle(SAID[HEAT])
        sheet.colorbar(drawn, ax=grid, fraction=0.04, aspect=30).set_label(f"[{UNITS[HEAT]}]")


@contextmanager
def _rows(
    path: Path, runs: Sequence[ComparedRun], maps: Sequence[Sequence[Map]], columns: int
) -> Iterator[tuple[Figure, Array]]:  # fmt: skip
    """A sheet with a row for each run."""
    width = max(INCHES * columns * (2 / max(columns, 2)) ** 0.5, INCHES) + 0.8
    height = 0.9 + len(runs) * (0.7 + ROW_INCHES * len(maps[0][0].rows))
    with _sheet(path, width, height) as sheet:
        yield sheet, sheet.subplots(len(runs), columns, squeeze=False)


def _titled(row: Sequence[Axes], run: ComparedRun, columns: Sequence[str], found: Sequence[Map], extent: Range) -> Any:
    """Maps of one run beside each other, each with what it shows."""
    for axes, said, one in zip(row, columns, found, strict=True):
        axes.set_title(f"{run.name}, {said}", fontsize=9)
        drawn = _map(axes, one, extent)
    return drawn


def _along(axes: Axes, run: ComparedRun, name: str) -> None:
    """Curves over the screw with their bands, bearings and the nut's travel."""
    axes.set_title(f"{run.name}, missing {name} ±2 sd [W/m]", fontsize=9)
    own = curves(run).get(name, [])
    axes.set_ylim(*frame_of(run, own).y)
    for curve in own:
        axes.fill_between(curve.x_mm, *curve.ends, color=_part(curve.colour), alpha=0.35, lw=0)
        axes.plot(curve.x_mm, curve.mean, color=_part(curve.colour), label=curve.name)
    axes.axhline(0.0, color=_part(paths.BOUND), lw=0.7)
    for span in bearings_mm(run.rig):
        axes.axvspan(*span, 0.0, 0.04, color=_part(paths.BOUND))
    if run.travel_mm:
        axes.axvspan(*run.travel_mm, 0.0, 0.04, color=_part(paths.NUT), label="nut's travel")
    axes.set_xlabel("place x [mm]", fontsize=8)
    axes.legend(fontsize=7)


@contextmanager
def _sheet(path: Path, width: float, height: float) -> Iterator[Figure]:
    """An empty figure in the colours of the views, written at the end."""
    import matplotlib  # takes a third of a second
    from matplotlib.figure import Figure

    ink, paper = _part(paths.TEXT), _part(paths.BACKGROUND)
    inked: Sequence[RcKeyType] = ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")
    papered: Sequence[RcKeyType] = ("figure.facecolor", "axes.facecolor", "savefig.facecolor", "legend.facecolor")
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


def _map(axes: Axes, found: Map, extent: Range) -> Any:
    from matplotlib.colors import LinearSegmentedColormap

    colours = LinearSegmentedColormap.from_list("diverging", [_part(colour) for colour in DIVERGING], SHADES)
    end = float(len(found.begins_s))
    box = (0.0, end, len(found.rows) - 0.5, -0.5)
    drawn = axes.imshow(
        np.ma.masked_invalid(found.values.T), colours, aspect="auto", interpolation="nearest", extent=box,
        vmin=extent[0], vmax=extent[1],
    )  # fmt: skip
    axes.set_yticks(np.arange(len(found.rows)), found.rows, fontsize=6)
    axes.set_xticks(found.ticks, found.texts, fontsize=7)
    axes.set_xlabel(found.title, fontsize=8)
    return drawn


def _part(colour: Sequence[int]) -> tuple[float, ...]:
    return tuple(part / 255 for part in colour)
