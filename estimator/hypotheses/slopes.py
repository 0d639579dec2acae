"""How a trial's readings move with parameters, open loop: a slope each.

A search asks for those of a model's own parameters at the same few points, beside one candidate after the other: a
trial keeps them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.accuracy.reference import slopes
from estimator.batch.open_loop import where_measured
from estimator.batch.trial import Posed, Trial
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.sensitivity import NominalColumn, nominal_columns
from estimator.sensitivity.tangent import tangent

POINTS = 3  # at which a trial keeps slopes: 5 MB each in an hour


@dataclass(frozen=True)
class Column:
    """One parameter "effect.param" of a model, which says where its effect sits."""

    model: Model
    path: str


@dataclass(frozen=True)
class Slope:
    """How readings move with one parameter.

    reading  (T, m) of each channel, NaN where nothing was measured
    length   (T,) of what the displacement reads, drives and rests joined (`accuracy.reference`)
    """

    reading: Array
    length: Array


def slopes_of(trial: Trial, posed: Posed, columns: Sequence[Column]) -> list[Slope]:
    """Slopes at what is posed, from which the models of the columns differ in where an effect sits at most."""
    tangents = (tangent(trial, posed, column.model, column.path) for column in columns)
    readings, reads = [], np.empty((len(columns), len(trial.rest)))
    for read, moved in zip(reads, nominal_columns(posed, tangents), strict=False):
        readings.append(where_measured(moved.reading, trial))
        read[:] = _reads(moved, trial, posed)
    return [Slope(*each) for each in zip(readings, slopes(reads, trial), strict=True)]


def slopes_beside(own: Model, trial: Trial, posed: Posed, columns: Sequence[Column]) -> list[Slope]:
    """The same, but those of the parameters of another model, which is near, at its values."""
    mine = [i for i, column in enumerate(columns) if column.path in own.values]
    rest = [i for i, column in enumerate(columns) if column.path not in own.values]
    known = _own_slopes(trial, own, posed, [columns[i].path for i in mine])
    found = dict(zip([*mine, *rest], [*known, *slopes_of(trial, posed, [columns[i] for i in rest])], strict=True))
    return [found[i] for i in range(len(columns))]


def _own_slopes(trial: Trial, model: Model, posed: Posed, paths: Sequence[str]) -> list[Slope]:
    """Slopes of a model's parameters at its own values, kept by the trial; it may be the one that is posed."""
    point = (*map(type, model.effects.values()), *(value.value for value in model.values.values()))
    kept = trial.slopes.pop(point, {})
    if missing := [path for path in paths if path not in kept]:
        here = posed if posed.forcing.model is model else trial.pose(model)
        found = slopes_of(trial, here, [Column(model, path) for path in missing])
        kept.update(zip(missing, found, strict=True))
    trial.slopes[point] = kept
    for oldest in list(trial.slopes)[:-POINTS]:
        del trial.slopes[oldest]
    return [kept[path] for path in paths]


def _reads(moved: NominalColumn, trial: Trial, posed: Posed) -> Array:
    """How what the displacement would read moves, (T,); the growth, where the model does not read it."""
    rig, known = trial.rig, np.isfinite(posed.forcing.readings.sd)
    if "displacement" in rig.channels and known[rig.index("displacement")]:
        return moved.reading[:, rig.index("displacement")]
    return moved.grown
