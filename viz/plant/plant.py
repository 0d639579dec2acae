"""A plant over weeks: for each figure a map with a row a rig, the worst first, in one .rrd file.

A colour lasts from a recording to the next one of the rig. How bad a rig is, is the mean of its last few recordings.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np
import rerun.blueprint as rrb
from matplotlib.dates import AutoDateLocator, date2num, num2date

from estimator.record import Array
from viz.drawing import paths
from viz.drawing.file import saved
from viz.drawing.scale import DIVERGING, WARM, Indices, Range, step_of, symmetric
from viz.drawing.views import flat, paged, summary_view, tabbed
from viz.figures.map import LABEL, Map, Sheet

VIEW = 1340.0, 640.0  # points
ROWS = int((VIEW[1] - 2.7 * LABEL) / LABEL)  # rigs on one page, each with its name beside it
COLUMNS = 300
MOST_DATES = 8
DAY_S = 86400.0
LAST = 3  # recordings that say how a rig is now


@dataclass(frozen=True)
class RigOverTime:
    """One rig: n recordings in order.

    name     as its row is called
    begun_s  (n,) s since 1970, or numbers of recordings
    values   (n, figures), NaN where there is none
    """

    name: str
    begun_s: Array
    values: Array


@dataclass(frozen=True)
class Figure:
    """What a map shows: its tab, its title, the unit of its colours. `signed`: 0 is best, and both signs are worse."""

    tab: str
    title: str
    unit: str
    signed: bool = False


def save(path: Path, rigs: Sequence[RigOverTime], figures: Sequence[Figure], dated: bool, summary: str) -> None:
    """Write all maps into `path` (.rrd), with `summary` (markdown); `dated`: times are dates."""
    begun = np.unique(np.concatenate([rig.begun_s for rig in rigs]))
    at_s = np.linspace(begun[0], begun[-1] + _usual(begun), COLUMNS, endpoint=False)
    pages = {f"{i}/{n}": (i, page) for i in range(len(figures)) for n, page in enumerate(paged(len(rigs), ROWS))}
    extents = [_extent(rigs, i, figure.signed) for i, figure in enumerate(figures)]
    sheets = {}
    for at, (i, page) in pages.items():
        some = [rigs[k] for k in worst_first(rigs, i)[page.start : page.stop]]
        drawn = _map(some, i, at_s, dated)
        sheets[at] = Sheet(drawn, extents[i], figures[i].unit, VIEW, DIVERGING if figures[i].signed else WARM)
    tabs = [_tab(figures[i], at, page, len(rigs), sheets[at]) for at, (i, page) in pages.items()]
    layout = tabbed([*tabs, rrb.Horizontal(summary_view(), name="Summary")])
    with saved(path, layout, f"plant: {len(rigs)} rigs", summary, float(at_s[-1] - at_s[0])) as file:
        for at, sheet in sheets.items():
            sheet.send(file / paths.PLANT / at)


def worst_first(rigs: Sequence[RigOverTime], figure: int) -> Indices:
    """Rigs by what a figure has been of late; those without it, who could not be used, before all."""
    late = [values[np.isfinite(values)][-LAST:] for values in (rig.values[:, figure] for rig in rigs)]
    bad = np.array([np.abs(some).mean() if len(some) else np.inf for some in late])
    return np.argsort(-bad, kind="stable")


def _map(rigs: Sequence[RigOverTime], figure: int, at_s: Array, dated: bool) -> Map:
    """Each column has what was known then."""
    values = np.full((len(at_s), len(rigs)), np.nan)
    for row, rig in enumerate(rigs):
        last = np.searchsorted(rig.begun_s, at_s, side="right") - 1
        values[last >= 0, row] = rig.values[last[last >= 0], figure]
    since_s, texts = _dates(at_s) if dated else _numbers(at_s)
    title = "begin of the recording" if dated else "number of the recording"
    return Map([rig.name for rig in rigs], at_s - at_s[0], values, since_s / (at_s[1] - at_s[0]), texts, title)


def _dates(at_s: Array) -> tuple[Array, list[str]]:
    """Where below a map which local date stands, s from its begin."""
    begin, end = (date2num(datetime.fromtimestamp(s)) for s in at_s[[0, -1]])
    days = AutoDateLocator(maxticks=MOST_DATES).tick_values(num2date(begin), num2date(end))
    days = days[(begin <= days) & (days <= end)]
    how = "%Y-%m-%d" if (days % 1.0 == 0.0).all() else "%m-%d %H:%M"
    return (days - begin) * DAY_S, [num2date(day).strftime(how) for day in days]


def _numbers(at_s: Array) -> tuple[Array, list[str]]:
    numbers = np.arange(np.ceil(at_s[0]), at_s[-1], max(1.0, step_of(at_s[-1] - at_s[0], MOST_DATES)))
    return numbers - at_s[0], [f"{number:g}" for number in numbers]


def _usual(begun: Array) -> float:
    """Between recordings: so long the last ones are shown."""
    return float(np.median(np.diff(begun))) if len(begun) > 1 else 1.0


def _extent(rigs: Sequence[RigOverTime], figure: int, signed: bool) -> Range:
    low, high = symmetric(np.concatenate([rig.values[:, figure] for rig in rigs]))
    return (low, high) if signed else (0.0, high)


def _tab(figure: Figure, at: str, page: range, count: int, sheet: Sheet) -> rrb.Container:
    more = f" {page.start + 1} to {page.stop}" if count > ROWS else ""
    view = flat(f"{paths.PLANT}/{at}", f"{figure.title}, the worst lately first", sheet.bounds)
    return rrb.Horizontal(view, name=f"{figure.tab}{more}")
