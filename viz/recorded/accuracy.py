"""The accuracy figure: reference over estimate, the line Y = X, and two lines parallel to it.

They go through the highest and the lowest (reference - estimate); their distance is the accuracy band.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import rerun as rr

from estimator.record import Array
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.frames import Axes
from viz.drawing.scale import Indices, Range, extent_of, rounded
from viz.recorded.run import JUDGED, ReviewedRun

SIDE, LOW = 1000.0, 420.0  # view units: side of the square, height of the frame below
LINE = 47.0
THIN_S = 20.0
BANDS = "bands"  # the table


@dataclass(frozen=True)
class Band:
    """Highest and lowest (reference - estimate), um; NaN where there is no reference."""

    high_um: float
    low_um: float

    @property
    def width_um(self) -> float:
        """The accuracy band."""
        return self.high_um - self.low_um


def band_of(runs: Sequence[ReviewedRun], estimate: str) -> Band:
    """The band over all ticks of all runs."""
    errors = np.concatenate([run.errors_um[estimate] for run in runs])
    errors = errors[np.isfinite(errors)]
    return Band(float(errors.max()), float(errors.min())) if len(errors) else Band(np.nan, np.nan)


@dataclass(frozen=True)
class Figure:
    """Two frames one above the other: reference over estimate, and the error over the estimate, enlarged."""

    square: Axes
    errors: Axes

    @property
    def bounds(self) -> tuple[Range, Range]:
        """What a view must show."""
        x, (top, _) = self.square.bounds
        return x, (top, self.errors.bounds[1][1])


def figure_of(runs: Sequence[ReviewedRun]) -> Figure:
    """The same frames for all estimates, so that the figures compare."""
    lengths = [v for run in runs for v in (run.reference_um, *(run.judged_um(name) for name in JUDGED))]
    extent = rounded(extent_of(*lengths))
    square = Axes(extent, extent, SIDE, SIDE, LINE)
    errors = rounded(extent_of(*(run.errors_um[name] for run in runs for name in JUDGED)))
    below = Axes(extent, errors, SIDE, LOW, LINE)
    gap = square.place(0, extent[0])[1] + 5.4 * LINE - below.place(0, errors[1])[1]
    return Figure(square, replace(below, down=float(gap)))


def send(at: Entity, runs: Sequence[ReviewedRun]) -> None:
    """Log the figures and the table of all runs that can be judged, once."""
    runs = [run for run in runs if run.is_judged]
    if not runs:
        return
    figure, reference = figure_of(runs), _reference(runs)
    for estimate in JUDGED:
        own, by = at / estimate, f"elongation by the {estimate} [µm]"
        figure.square.draw(own / "axes", by, f"elongation: {reference} [µm]")
        figure.errors.draw(own / "error_axes", by, f"{reference} − {estimate} [µm]")
        for i, run in enumerate(runs):
            _points(own / "runs" / paths.root(run.name), run, estimate, figure, paths.RUNS[i % len(paths.RUNS)])
        _parallels(own, band_of(runs, estimate), figure)
        _key(own / "key", runs, figure.square)
    (at / BANDS).text(bands_table(runs))


def _points(at: Entity, run: ReviewedRun, estimate: str, figure: Figure, colour: paths.Colour) -> None:
    errors = run.errors_um[estimate]
    shown = thinned(run.track.time_s, errors)
    x = run.judged_um(estimate)[shown]
    for name, axes, y in (("square", figure.square, run.reference_um), ("errors", figure.errors, errors)):
        places = axes.place(x, y[shown]).astype(np.float32)
        (at / name).log(rr.Points2D(places, radii=rr.Radius.ui_points(1.6), colors=colour, draw_order=10.0))


def thinned(time_s: Array, errors_um: Array) -> Indices:
    """Ticks to draw: one in 20 s, and always the one with the highest and the one with the lowest error."""
    known = np.flatnonzero(np.isfinite(errors_um))
    if not len(known):
        return known
    first = np.unique(np.floor(time_s[known] / THIN_S), return_index=True)[1]
    extremes = [known[errors_um[known].argmax()], known[errors_um[known].argmin()]]
    return np.unique([*known[first], *extremes])


def _parallels(at: Entity, band: Band, figure: Figure) -> None:
    _line(at / "equal", figure, 0.0, paths.TEXT)
    if not np.isfinite(band.width_um):
        return
    _line(at / "highest", figure, band.high_um, paths.READING)
    _line(at / "lowest", figure, band.low_um, paths.READING)
    lo, hi = figure.square.x
    title = [f"accuracy band {band.width_um:.2f} µm: {band.low_um:+.2f} ... {band.high_um:+.2f}"]
    place = figure.square.place([hi - 0.34 * (hi - lo)], [lo + 0.13 * (hi - lo)])
    (at / "band").words(place, title, [paths.READING])


def _line(at: Entity, figure: Figure, shift: float, colour: paths.Colour) -> None:
    """The line y = x + shift in the square, and the same as a level line among the errors."""
    lo, hi = figure.square.x
    left, right = max(lo, lo - shift), min(hi, hi - shift)
    sloping = figure.square.place([left, right], [left + shift, right + shift])
    strips = [sloping, figure.errors.place([lo, hi], shift)]
    at.log(rr.LineStrips2D(strips, radii=rr.Radius.ui_points(0.8), colors=colour, draw_order=4.0))


def _key(at: Entity, runs: Sequence[ReviewedRun], axes: Axes) -> None:
    """Names of the runs in their colours, in the empty corner above the diagonal."""
    n = min(len(runs), len(paths.RUNS))
    left, top = axes.place(axes.x[0], axes.y[1])
    places = np.stack([np.full(n, left + 0.1 * SIDE), top + LINE * (0.3 + np.arange(n))], axis=-1)
    at.words(places, [run.name for run in runs[:n]], list(paths.RUNS[:n]))


def bands_table(runs: Sequence[ReviewedRun]) -> str:
    """The bands as a markdown table, each run and all together."""
    rows = [(run.name, [run]) for run in runs] + ([("**all**", list(runs))] if len(runs) > 1 else [])
    head = "| run | " + " | ".join(JUDGED) + " |\n|:--|" + ":--|" * len(JUDGED)
    lines = [f"| {name} | " + " | ".join(_cell(some, estimate) for estimate in JUDGED) + " |" for name, some in rows]
    text = f"lowest ... highest (reference − estimate), **width of the band**, µm\n\nreference: {_reference(runs)}"
    return f"## Accuracy band\n\n{text}\n\n{head}\n" + "\n".join(lines) + "\n"


def _reference(runs: Sequence[ReviewedRun]) -> str:
    return " / ".join(dict.fromkeys(run.reference_name for run in runs))


def _cell(runs: Sequence[ReviewedRun], estimate: str) -> str:
    band = band_of(runs, estimate)
    return (
        f"{band.low_um:+.2f} ... {band.high_um:+.2f}, **{band.width_um:.2f}**" if np.isfinite(band.width_um) else "none"
    )
