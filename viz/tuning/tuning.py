"""What tuning did to a filter's innovations: views before and after, side by side, in one .rrd file.

The innovations stand over their own sd, so that one scale suits every channel: 95 % of them belong between the lines at
+-2, and the mean of a minute belongs at 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from estimator.record import Array
from viz.drawing import bars, paths
from viz.drawing.bars import NisBars
from viz.drawing.entity import Entity
from viz.drawing.file import distinct, saved
from viz.drawing.scale import MINUTE_S, minutes
from viz.tuning.autocorrelation import map_of, shades_of
from viz.tuning.layout import blueprint
from viz.tuning.tuned import Tuning


def save(path: Path, channels: Sequence[str], runs: Sequence[Tuning], nis: Sequence[NisBars], summary: str) -> None:
    """Write all runs into `path` (.rrd), with `summary` (markdown); m channels, by name; figures of all recordings."""
    runs = distinct(runs)
    extent = shades_of(*(side.autocorrelation for run in runs for side in run.sides.values()))
    name, last_s = "tuning: " + ", ".join(run.name for run in runs), max(run.time_s[-1] for run in runs)
    with saved(path, blueprint(channels, runs, nis), name, summary, float(np.floor(last_s))) as file:
        for i, each in enumerate(nis):
            bars.send(file / paths.BARS / str(i), each)
        for run in runs:
            at = file / paths.root(run.name)
            for side, one in run.sides.items():
                map_of(channels, run.lags_s, one, extent).send(at / paths.AUTOCORRELATION / side)
                for i, channel in enumerate(channels):
                    own = at / paths.scaled(side, channel)
                    _innovations(own, paths.COMPARED_AS[side], run.time_s, one.scaled[:, i])


def _innovations(at: Entity, colour: paths.Colour, time_s: Array, scaled: Array) -> None:
    """One channel's innovations, how they look and what they are."""
    (at / "each").dots("innovation / sd", colour, 0.8)
    (at / "each").known(time_s, scaled)
    (at / "mean").lines(["mean of a minute"], [paths.REFERENCE], 1.5)
    begins, means = minutes(time_s, scaled)
    (at / "mean").curves(begins + MINUTE_S / 2, means)
    (at / "bounds").lines(["±2 sd", ""], [paths.READING] * 2, 1.0, "Off")
    (at / "bounds").curves(time_s[[0, -1]], np.tile([2.0, -2.0], (2, 1)))
