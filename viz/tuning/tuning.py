"""What tuning did to a filter's innovations: views before and after, side by side, in one .rrd file.

The innovations stand over their own sd, so that one scale suits every channel: 95 % of them belong between the lines at
+-2, and the mean of a minute belongs at 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rerun as rr

from estimator.record import Array
from viz.drawing import paths, series
from viz.drawing.file import distinct, saved
from viz.drawing.scale import minutes
from viz.tuning import figures
from viz.tuning.layout import blueprint
from viz.tuning.tuned import Side, Tuning

SIDES = {"before": paths.BEFORE, "after": paths.AFTER}


@dataclass(frozen=True)
class Nis:
    """A figure that belongs at 1, of each channel over all recordings, (m,); NaN where there is none."""

    title: str
    before: Array
    after: Array


def save(path: Path, channels: Sequence[str], runs: Sequence[Tuning], nis: Sequence[Nis], summary: str) -> None:
    """Write all runs into `path` (.rrd), with `summary` (markdown); m channels, by name."""
    runs = distinct(runs)
    extent = figures.shades_of(*(side.autocorrelation for run in runs for side in (run.before, run.after)))
    layout = blueprint(channels, runs, [each.title for each in nis])
    name, last_s = "tuning: " + ", ".join(run.name for run in runs), max(run.time_s[-1] for run in runs)
    with saved(path, layout, name, summary, float(np.floor(last_s))) as rec:
        for i, each in enumerate(nis):
            figures.send_bars(rec, f"{paths.BARS}/{i}", channels, each.before, each.after)
        for run in runs:
            _send(rec, channels, run, extent)


def _send(rec: rr.RecordingStream, channels: Sequence[str], run: Tuning, extent: tuple[float, float]) -> None:
    root = paths.root(run.name)
    figures.send_key(rec, f"{root}/{paths.AUTOCORRELATION}/key", extent)
    for name, colour in SIDES.items():
        side: Side = getattr(run, name)
        at = f"{root}/{paths.AUTOCORRELATION}/{name}"
        figures.send_map(rec, at, channels, run.lags_s, side.autocorrelation, extent)
        begins, means = minutes(run.time_s, side.scaled)
        for i, channel in enumerate(channels):
            at = paths.scaled(root, name, channel)
            style(rec, at, colour)
            series.send_known(rec, f"{at}/each", run.time_s, side.scaled[:, i])
            series.send(rec, f"{at}/mean", begins + 30.0, means[:, i])
            series.send(rec, f"{at}/bounds", run.time_s[[0, -1]], np.tile([2.0, -2.0], (2, 1)))


def style(rec: rr.RecordingStream, at: str, colour: paths.Colour) -> None:
    """Log the looks of one channel's innovations, once."""
    series.dots(rec, f"{at}/each", "innovation / sd", colour, 0.8)
    series.lines(rec, f"{at}/mean", ["mean of a minute"], [paths.REFERENCE], 1.5)
    series.lines(rec, f"{at}/bounds", ["±2 sd", ""], [paths.READING] * 2, 1.0, "Off")
