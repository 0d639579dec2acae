"""What is always wrong with a model on some recordings: the pattern that an event has to stand out of.

    S = scatter + parameters as unsure as their sources say + heat smooth in place, steady or slowly changing
        + errors of the thermometers: offset, lag, gain, wandering

Each at the size that the recordings together make most likely (`missing_heat.causes`): a model of another machine has a
large pattern, and only what does not fit into it counts.
"""

from collections.abc import Sequence

import numpy as np

from estimator.events.event import HOT
from estimator.events.signature import Signature
from estimator.missing_heat.causes import Averages, Cause, most_likely
from estimator.missing_heat.missing_heat import HEATS, ZERO_UM
from estimator.missing_heat.zones import alike
from estimator.record import Array
from estimator.work import Workers

WANDERS_S = 1200.0
ANY = 1e6  # K^2, variance of what may be of any size
FIRST = {  # sizes to begin with, and the least: W/m, sd of the sources, K, s, K/K, um
    "heat": (5.0, 1e-3), "heat while driving": (5.0, 1e-3), "changing heat": (1.0, 1e-3),
    "changing heat while driving": (1.0, 1e-3), "parameters": (0.3, 0.01),
    "offset": (0.02, 0.005), "drift": (0.02, 0.005), "lag": (1.0, 0.3), "gain": (0.003, 0.001),
    "together": (0.01, 0.003), "offset um": (0.1, 0.03), "drift um": (0.1, 0.03),
}  # fmt: skip


def pattern(seen: Signature, found: Sequence[Array] = ()) -> Averages:
    """Averages of a recording with all causes; `found`: columns (N,) of any size, which are known to be there."""
    known = np.diag(seen.variance)
    for channel in seen.trial.floating:
        rows = np.flatnonzero(seen.channel == channel)
        known[np.ix_(rows, rows)] += ZERO_UM**2
    for column in found:
        known += np.outer(column, column) * (ANY / max(float(column @ column), 1e-300))
    causes = {**_heats(seen), **_readings(seen)}
    if seen.by_parameter:
        columns = np.stack(list(seen.by_parameter.values()), axis=1)
        causes["parameters"] = Cause(np.arange(len(seen.y)), columns @ columns.T)
    return Averages(seen.y, known, causes)


def sized(measured: Sequence[Averages], workers: Workers) -> dict[str, float]:
    """Sizes of the causes, common to all recordings."""
    names = sorted({name for each in measured for name in each.causes})
    first, least = ({name: FIRST[name][k] for name in names} for k in (0, 1))
    return most_likely(measured, first, least, workers)


def _heats(seen: Signature) -> dict[str, Cause]:
    """Heat in the zones of the screw and the bodies."""
    at = [i for i, carrier in enumerate(seen.carriers) if carrier.kind == HOT]
    places = tuple(carrier.zone for carrier in seen.carriers if carrier.zone is not None)
    moves = seen.moves[:, :, at] * np.array([zone.length_m for zone in places])
    drive, near = seen.spans.drive.astype(float), _near(seen.spans.at_s)
    both = np.outer(drive, drive)
    in_times = (np.ones_like(near), both, near, near * both)
    in_place, every = moves @ alike(places), np.arange(len(seen.y))
    causes = {}
    for name, time in zip(HEATS, in_times, strict=True):
        in_time = np.einsum("nbz,bc->ncz", in_place, time, optimize=True)
        causes[name] = Cause(every, np.tensordot(in_time, moves, ((1, 2), (1, 2))))
    return causes


def _readings(seen: Signature) -> dict[str, Cause]:
    """Errors of readings, each channel's own but for one that all thermometers share."""
    heat = seen.trial.rig.is_thermometer[seen.channel]
    moved = seen.trial.drive.inputs.motion.moved[1:, 0]
    moved = moved if moved.any() else np.ones_like(moved)
    since = (np.bincount(seen.spans.of_tick, moved) / np.bincount(seen.spans.of_tick))[seen.span]
    own = (seen.channel[:, None] == seen.channel).astype(float)
    wander = _near(seen.spans.at_s)[np.ix_(seen.span, seen.span)]

    def cause(rows: Array, covariance: Array) -> Cause:
        return Cause(rows, covariance[np.ix_(rows, rows)])

    causes = {}
    for unit, rows in (("", np.flatnonzero(heat)), (" um", np.flatnonzero(~heat))):
        if len(rows):
            causes[f"offset{unit}"] = cause(rows, own * np.outer(since, since))
            causes[f"drift{unit}"] = cause(rows, own * wander)
    if heat.any():
        rows = np.flatnonzero(heat)
        causes["lag"] = cause(rows, own * np.outer(seen.rate, seen.rate))
        causes["gain"] = cause(rows, own * np.outer(seen.rise, seen.rise))
        causes["together"] = cause(rows, wander)
    return causes


def _near(at_s: Array) -> Array:
    """Correlation of what is smooth in time."""
    return np.asarray(np.exp(-np.abs(at_s[:, None] - at_s) / WANDERS_S))
