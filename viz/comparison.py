"""What one or two models say of recordings, before and after a change, beside each other: one .rrd file.

Curves are means of ten seconds: a model alone is smooth, and two models on hours of ticks would be a heavy file.
"""

from __future__ import annotations

import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rerun as rr

from estimator.errors import InputError
from estimator.record import Array
from estimator.rig import Rig
from viz import bars, columns, comparison_curves, comparison_maps, moment, paths
from viz.bars import Bars
from viz.columns import Indices
from viz.comparison_layout import blueprint
from viz.save import distinct


@dataclass(frozen=True)
class HeatMap:
    """Heat that would repair a model alone, at n times.

    time_s   (n,);  places_mm  (x,) on the screw;  W_m  (n, x)
    bodies   names of what is not a place;  W  (n, bodies)
    """

    time_s: Array
    places_mm: Array
    W_m: Array
    bodies: Sequence[str]
    W: Array


@dataclass(frozen=True)
class Side:
    """One model on one recording of K ticks.

    open_loop, predicted, innovation   (K, m) what channels read by the model alone, and a tick ahead by the filter
    elongation_um, sigma_um, open_loop_um  (K,) by the filter, with its sd, and by the model alone
    misfit   reading minus the model alone at times of its own, (n,) and (n, m); a zero without meaning taken out
    """

    open_loop: Array
    predicted: Array
    innovation: Array
    elongation_um: Array
    sigma_um: Array
    open_loop_um: Array
    misfit_time_s: Array
    misfit: Array
    heat: HeatMap


@dataclass(frozen=True)
class Compared:
    """One recording of K ticks under one model, or two: before and after.

    name         shown as the title of its tab
    measured     (K, m);   readings_um  (K,) displacement joined to the start, NaN where there is none
    """

    name: str
    rig: Rig
    time_s: Array
    measured: Array
    readings_um: Array
    sides: tuple[Side, ...]

    @property
    def thermometers(self) -> Indices:
        """Columns of the thermometers among the channels, in order."""
        return columns.thermometers(self.rig)

    @property
    def lengths(self) -> Indices:
        """Columns of the others."""
        return columns.lengths(self.rig)


def save(
    path: Path, runs: Sequence[Compared], models: Sequence[str], figures: Mapping[str, Sequence[Bars]], summary: str
) -> None:  # fmt: skip
    """Write all runs into `path` (.rrd) with `summary` (markdown); models by name.

    figures  of all runs, by the name of their tab; those of the first stand beside the summary
    """
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}")
    runs = distinct(runs)
    scales = comparison_maps.scales_of(runs)
    layout = blueprint(runs, models, figures)
    rec = rr.RecordingStream(paths.APPLICATION, recording_id=uuid.uuid4())
    rec.set_log_time_enabled(False)
    rec.save(path, default_blueprint=layout)
    rec.send_blueprint(layout, make_active=True, make_default=True)
    rec.send_recording_name(f"{' and '.join(models)}: {', '.join(run.name for run in runs)}")
    rec.log(paths.SUMMARY, rr.TextDocument(summary, media_type=rr.MediaType.MARKDOWN), static=True)
    moment.send(rec, float(np.floor(max(run.time_s[-1] for run in runs))))
    for tab, some in figures.items():
        for i, each in enumerate(some):
            bars.send(rec, bars.at(tab, i), each)
    for run in runs:
        comparison_curves.send(rec, run)
        comparison_maps.send(rec, run, scales)
    rec.disconnect()
