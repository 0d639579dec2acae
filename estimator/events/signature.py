"""What a recording shows, span by span, and how everything that may begin would move it.

    y = sum of a step from some time on, at some place + what is always wrong with the model + scatter

Readings are averaged over spans of minutes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.batch.open_loop import open_loop_misfit
from estimator.batch.trial import Trial
from estimator.batch.trials import unjudged
from estimator.events.carriers import Carrier, carriers
from estimator.events.spans import Spans, spans
from estimator.missing_heat.misfit import spikes
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.sensitivity.averages import Averaged, moves
from estimator.sensitivity.sensitivity import nominal_columns
from estimator.sensitivity.tangent import tangent


@dataclass(frozen=True)
class Signature:
    """N averages of one recording.

    y, variance    (N,) misfit of the model alone, K or um, and variance of its scatter
    channel, span  (N,) which channel in which span
    moves    (N, B, C) by 1 of each of the C `carriers` during each of the B spans
    by_parameter   (N,) by one sd of what sources say of each parameter of the model, by path
    rise, rate     (N,) of the model's reading since the start, K, and K/s
    """

    trial: Trial
    spans: Spans
    carriers: Sequence[Carrier]
    y: Array
    variance: Array
    channel: Array
    span: Array
    moves: Array
    by_parameter: Mapping[str, Array]
    rise: Array
    rate: Array


def signature(model: Model, trial: Trial, most_s: float | None = None) -> Signature:
    """Run the model alone beside a recording at a tick that serves for slow heat; most_s: of a span."""
    posed, cut = trial.pose(model), spans(trial.rest, most_s)
    rest = open_loop_misfit(trial, posed)
    m, run = rest.shape[1], posed.run
    cell = cut.of_tick[:, None] * m + np.arange(m)
    known = np.isfinite(rest) & ~spikes(rest, cell, posed.forcing.readings.sd)
    averaged, rows = Averaged.of(cell, known)
    found = carriers(trial, posed, model)
    zeroed = [np.flatnonzero(rows % m == channel) for channel in trial.floating]

    def mean(values: Array) -> Array:
        return without_zeros(averaged.mean(values), zeroed, averaged.count)

    doubtful = [path for path in model.free() if model.param(path).sd]
    found_by = nominal_columns(posed, (tangent(trial, posed, model, path) for path in doubtful))
    columns = {
        path: mean(column.reading) * float(model.param(path).sd or 0.0)
        for path, column in zip(doubtful, found_by, strict=True)
    }
    variance = averaged.mean(np.broadcast_to(posed.system.R, rest.shape)) / averaged.count
    moved = moves(posed, np.stack([carrier.push for carrier in found], axis=2), cut.of_tick, averaged)
    moved = without_zeros(moved, zeroed, averaged.count)
    rate = np.diff(run.lagged, axis=0, prepend=run.spot[:1]) / trial.rig.tick_s
    rise = averaged.mean(run.lagged - run.spot[:1])
    return Signature(
        trial, cut, found, mean(rest), variance, rows % m, rows // m, moved, columns, rise, averaged.mean(rate)
    )  # fmt: skip


def without_zeros(columns: Array, zeroed: Sequence[Array], count: Array) -> Array:
    """Columns (N, ...) less their mean over the rows of each channel whose zero has no meaning."""
    for rows in zeroed:
        if len(rows):
            columns[rows] -= np.tensordot(count[rows], columns[rows], 1) / count[rows].sum()
    return columns


@dataclass(frozen=True)
class AsRead:
    """One recording as it was read, at a tick that serves for slow heat: nothing is refused, for why is asked.

    off, alone  (T, m) misfit, and what the channels would read by the model alone
    """

    rig: Rig
    recording: Recording
    time_s: Array
    off: Array
    alone: Array


def as_read(model: Model, rig: Rig, recording: Recording) -> AsRead:
    """Run the model alone beside a recording."""
    trial = unjudged(model, rig, recording)
    posed = trial.pose(model)
    alone = posed.run.lagged + posed.offset[1:]
    return AsRead(rig, recording, trial.rest.time_s, open_loop_misfit(trial, posed), alone)
