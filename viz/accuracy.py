"""The accuracy figure: reference over estimate, the line Y = X, and the two lines parallel to it through the highest and
the lowest (reference - estimate). The distance of the two is the accuracy band.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from estimator.record import Array
from viz import paths
from viz.axes import Axes, words
from viz.run import Run
from viz.scale import rounded

SIDE = 1000.0  # view units
THIN_S = 20.0
SHOWN = ("filter", "polyline")


@dataclass(frozen=True)
class Band:
    """Highest and lowest (reference - estimate), um; NaN where there is no reference."""

    high_um: float
    low_um: float

    @property
    def width_um(self) -> float:
        """The accuracy band."""
        return self.high_um - self.low_um


def band_of(runs: Sequence[Run], estimate: str) -> Band:
    """The band over all ticks of all runs."""
    errors = np.concatenate([run.errors_um(estimate) for run in runs])
    errors = errors[np.isfinite(errors)]
    return Band(float(errors.max()), float(errors.min())) if len(errors) else Band(np.nan, np.nan)


def axes_of(runs: Sequence[Run]) -> Axes:
    """One square for all estimates, so that the figures compare."""
    values = np.concatenate([v for run in runs for v in (run.reference_um, *(run.estimates_um[e] for e in SHOWN))])
    values = values[np.isfinite(values)]
    extent = rounded((float(values.min()), float(values.max())) if len(values) else (0.0, 1.0))
    return Axes(extent, extent, SIDE, SIDE)


def send(rec: rr.RecordingStream, runs: Sequence[Run]) -> None:
    """Log the figures and the table of all runs, once."""
    axes = axes_of(runs)
    reference = " / ".join(dict.fromkeys(run.reference_name for run in runs))
    for estimate in SHOWN:
        at = f"{paths.ACCURACY}/{estimate}"
        axes.draw(rec, f"{at}/axes", f"elongation by the {estimate} [µm]", f"elongation by {reference} [µm]")
        for i, run in enumerate(runs):
            _points(rec, f"{at}/runs/{paths.root(run.name)}", run, estimate, axes, paths.RUNS[i % len(paths.RUNS)])
        _parallels(rec, at, band_of(runs, estimate), axes)
        _key(rec, f"{at}/key", runs, axes)
    table = rr.TextDocument(bands_table(runs), media_type=rr.MediaType.MARKDOWN)
    rec.log(paths.BANDS, table, static=True)


def _points(rec: rr.RecordingStream, at: str, run: Run, estimate: str, axes: Axes, colour: paths.Colour) -> None:
    shown = thinned(run.track.time_s, run.errors_um(estimate))
    places = axes.place(run.estimates_um[estimate][shown], run.reference_um[shown]).astype(np.float32)
    dots = rr.Points2D(places, radii=rr.Radius.ui_points(1.6), colors=colour, draw_order=10.0)
    rec.log(at, dots, static=True)


def thinned(time_s: Array, errors_um: Array) -> Array:
    """Ticks to draw: one in 20 s, and always the one with the highest and the one with the lowest error."""
    known = np.flatnonzero(np.isfinite(errors_um))
    if not len(known):
        return known
    first = np.unique(np.floor(time_s[known] / THIN_S), return_index=True)[1]
    extremes = [known[errors_um[known].argmax()], known[errors_um[known].argmin()]]
    return np.unique([*known[first], *extremes])


def _parallels(rec: rr.RecordingStream, at: str, band: Band, axes: Axes) -> None:
    lo, hi = axes.x
    rec.log(
        f"{at}/equal",
        rr.LineStrips2D(
            [axes.place([lo, hi], [lo, hi])], radii=rr.Radius.ui_points(0.8), colors=paths.TEXT, draw_order=3.0
        ),
        static=True,
    )
    if not np.isfinite(band.width_um):
        return
    pair = [axes.place(*clipped(lo, hi, shift)) for shift in (band.high_um, band.low_um)]
    rec.log(
        f"{at}/parallels",
        rr.LineStrips2D(pair, radii=rr.Radius.ui_points(1.0), colors=paths.READING, draw_order=4.0),
        static=True,
    )
    title = [f"band {band.width_um:.2f} µm: {band.low_um:+.2f} ... {band.high_um:+.2f} µm from Y = X"]
    words(rec, f"{at}/band", axes.place([hi - 0.36 * (hi - lo)], [lo + 0.14 * (hi - lo)]), title, [paths.READING])


def clipped(lo: float, hi: float, shift: float) -> tuple[list[float], list[float]]:
    """The line y = x + shift inside the square lo ... hi: its two x and its two y."""
    left, right = max(lo, lo - shift), min(hi, hi - shift)
    return [left, right], [left + shift, right + shift]


def _key(rec: rr.RecordingStream, at: str, runs: Sequence[Run], axes: Axes) -> None:
    """Names of the runs in their colours, in the empty corner above the diagonal."""
    n = min(len(runs), len(paths.RUNS))
    left, top = axes.place(axes.x[0], axes.y[1])
    places = np.stack([np.full(n, left + 0.1 * SIDE), top + SIDE * (0.02 + 0.045 * np.arange(n))], axis=-1)
    words(rec, at, places, [run.name for run in runs[:n]], list(paths.RUNS[:n]))


def bands_table(runs: Sequence[Run]) -> str:
    """The bands as a markdown table, each run and all together."""
    rows = [(run.name, [run]) for run in runs] + ([("**all**", list(runs))] if len(runs) > 1 else [])
    head = "| run | reference | " + " | ".join(SHOWN) + " |\n|:--|:--|" + ":--|" * len(SHOWN)
    lines = [
        f"| {name} | {_reference(some)} | " + " | ".join(_cell(some, e) for e in SHOWN) + " |" for name, some in rows
    ]
    text = "lowest ... highest (reference − estimate), **width of the band**, µm"
    return f"## Accuracy band\n\n{text}\n\n{head}\n" + "\n".join(lines) + "\n"


def _reference(runs: Sequence[Run]) -> str:
    return " / ".join(dict.fromkeys(run.reference_name for run in runs))


def _cell(runs: Sequence[Run], estimate: str) -> str:
    band = band_of(runs, estimate)
    return (
        f"{band.low_um:+.2f} ... {band.high_um:+.2f}, **{band.width_um:.2f}**" if np.isfinite(band.width_um) else "none"
    )
