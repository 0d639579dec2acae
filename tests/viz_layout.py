"""Where views and labels stand in a window of some size, as the viewer does it, in points; no viewer needed."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import rerun.blueprint as rrb

from tests.viz_read import logged

BARS, TABS, TITLE, TIMES = 66.0, 30.0, 28.0, 20.0  # heights: of the window's own, a row of tabs, a title, a time axis
LABEL, LETTER, MARGIN = 21.0, 7.0, 12.0  # of a label
APART_X, APART_Y = 62.0, 25.0  # points between labels of axes: fewer, and the viewer draws none
ENTRY, AROUND, MOST = 23.5, 8.0, 0.77  # of a legend, and the share of a plot's height that it may take
TIME_STEPS = (1.0, 10.0, 60.0, 600.0, 3600.0, 43200.0, 86400.0)


@dataclass(frozen=True)
class Placed:
    """A view of a page in a rectangle of the window, its title left out."""

    page: str
    view: Any
    width: float
    height: float

    def property(self, name: str, field: str) -> Any:
        """What the layout says of a view; None where it says nothing."""
        found = self.view.properties.get(name)
        value = getattr(found, field) if found is not None else None
        return None if value is None else value.as_arrow_array().to_pylist()[0]


def placed(layout: rrb.Blueprint, window: tuple[int, int]) -> Iterator[Placed]:
    """All views of a layout."""
    width, height = window
    yield from _inside(layout.root_container, "", width, height - BARS)


def _inside(part: Any, page: str, width: float, height: float) -> Iterator[Placed]:
    if not isinstance(part, rrb.Container):
        yield Placed(page, part, width, height - (0.0 if part.titlebar is False else TITLE))
        return
    page, count = f"{page}/{part.name or ''}", len(part.contents)
    if isinstance(part, rrb.Tabs):
        for inner in part.contents:
            yield from _inside(inner, page, width, height - TABS)
        return
    columns = {"Horizontal": count, "Vertical": 1}.get(part.kind.name, part.grid_columns or count)
    across, down = _shares(part.column_shares, columns), _shares(part.row_shares, -(-count // columns))
    for i, inner in enumerate(part.contents):
        yield from _inside(inner, page, width * across[i % columns], height * down[i // columns])


def _shares(shares: Sequence[float] | None, count: int) -> np.ndarray:
    each = np.array(shares or [1.0] * count, dtype=float)
    return each / each.sum()


def labels_of_axis(extent: Sequence[float], points: float, steps: Sequence[float], apart: float) -> int:
    """How many labels an axis has whose labels are multiples of a step, the finest that leaves them apart."""
    lo, hi = extent
    fit = [step for step in steps if step * points >= apart * (hi - lo)]
    return int(np.floor(hi / fit[0] + 1e-9) - np.ceil(lo / fit[0] - 1e-9)) + 1 if fit else 0


def entries(path: Path, origin: str) -> int:
    """How many curves have a name below an origin in a saved file."""
    names = set()
    for batch in _always(path, origin):
        for column in batch.schema.names:
            if column.endswith(":names"):
                names |= {*(batch.column(column)[-1].as_py() or ())}
    return len(names - {""})


def labels(path: Path, origin: str, one: Placed) -> list[tuple[str, np.ndarray]]:
    """Labels of a hand-drawn figure that hold at all times, with their boxes (left, top, right, bottom), points."""
    bounds = one.property("VisualBounds2D", "range")
    (left, right), (top, bottom) = bounds["x_range"], bounds["y_range"]
    zoom = min(one.width / (right - left), one.height / (bottom - top))
    middle = np.array([(left + right) / 2, (top + bottom) / 2])
    found = []
    for batch in _always(path, origin):
        if "Points2D:labels" in batch.schema.names:
            texts, at = (batch.column(f"Points2D:{name}")[-1].as_py() for name in ("labels", "positions"))
            for text, place in zip(texts or (), at or (), strict=False):
                x, y = zoom * (np.array(place) - middle) + np.array([one.width, one.height]) / 2
                half = (LETTER * len(text) + MARGIN) / 2
                found.append((text, np.array([x - half, y, x + half, y + LABEL])))
    return found


def _always(path: Path, origin: str) -> Iterator[Any]:
    """What was logged for all times below an origin."""
    below = (each for entity, each in logged(path).items() if entity.startswith(f"/{origin}/"))
    return (batch for each in below for always, batch in each if always)


def covered(one: np.ndarray, other: np.ndarray) -> float:
    """Share of a label's box that another covers."""
    wide, high = np.minimum(one[2:], other[2:]) - np.maximum(one[:2], other[:2])
    return float(max(wide, 0.0) * max(high, 0.0) / np.prod(one[2:] - one[:2]))
