"""The filter over a whole recording by the compiled engine: the same numbers as `Filter`, a tick at a time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from estimator.batch import batch
from estimator.batch.system import Chunk
from estimator.batch.trial import Posed, Trial
from estimator.filter import Filter
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.state.gate import GATE, Mute
from estimator.state.report import modes
from estimator.step import Track

ROWS = 2048  # ticks whose profiles are worked out at a time


def replay(
    model: Model, rig: Rig, recording: Recording, mute: Mute | None = None, each: Callable[[int], None] = lambda _: None
) -> Track:
    """All ticks of a recording. `each` hears how many ticks are done."""
    first = Filter(model, rig, mute)
    steps = []
    for sample in recording:
        steps.append(first.step(sample))
        if first.started:
            break
    if not first.started or len(steps) == len(recording):
        return Track.of(steps, *_places(first))
    trial = Trial(model, rig, recording, mute, gated=False)
    posed, parts = trial.pose(model), [Track.of(steps, *_places(first))]
    for chunk in batch.passes(posed.system, GATE, trial.wild):
        parts += [_part(first, trial, posed, chunk, slice(k, k + ROWS)) for k in range(0, len(chunk.x), ROWS)]
        each(len(steps) + chunk.ticks.stop)
    return Track.joined(parts)


def _places(first: Filter) -> tuple[Array, tuple[str, ...]]:
    return (first.view.x_mm, first.view.bodies) if first.started else (np.empty(0), ())


def _part(first: Filter, trial: Trial, posed: Posed, chunk: Chunk, some: slice) -> Track:
    """The estimates of some of a chunk's ticks in the terms of a person."""
    view, n = first.view, posed.state.n
    x, P, fused = chunk.x[some], chunk.P[some], chunk.fused[some]
    at = slice(chunk.ticks.start + some.start, chunk.ticks.start + some.start + len(x))
    grown = posed.system.grown[at]
    rest = trial.rest.rows(at)
    um = 1.0 if view.has_span else np.nan
    now = posed.state.elongation(0.0)
    weighed = P @ now
    variance = weighed @ now + 2 * grown * weighed[:, -2] + grown**2 * P[:, -2, -2]
    predicted = chunk.predicted[some] + posed.offset[1:][at] + posed.run.lag[at] + posed.run.late[at]
    position = first.places.held(rest.inputs.get("position", np.full(len(rest), np.nan)))
    table = view.table_error(position)
    growth = (table * (x[:, :n] - posed.run.z[0])).sum(axis=1)
    return Track(
        view.x_mm,
        view.bodies,
        trial.rig.names,
        time_s=rest.time_s,
        mode=modes(fused, trial.rig),
        elongation_um=um * (x @ now + grown * x[:, -2]),
        sigma_um=um * np.sqrt(np.maximum(variance, 0.0)),
        open_loop_um=um * grown,
        profile_C=x[:, :n] @ view.profile.T,
        profile_sd_K=np.sqrt(np.maximum(((P[:, :n, :n] @ view.profile.T) * view.profile.T).sum(axis=1), 0.0)),
        bodies_C=x[:, n - len(view.bodies) : n],
        error_at_table_um=growth * (1.0 + x[:, -2]),
        measured=rest.channels,
        predicted=predicted,
        innovation=rest.channels - predicted,
        innovation_sd=chunk.sd[some],
        fused=fused,
        open_loop=posed.run.lagged[at] + posed.offset[1:][at] + posed.state.channel_zeros(posed.system.x0),
        nis=chunk.nis[some],
        nis_channels=fused.sum(axis=1),
        position_mm=position,
    )
