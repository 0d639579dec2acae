"""Displacement readings: what they have beside growth, for warm probes add to them and a warm bar takes away; and the
level of many, without their scatter."""

from collections.abc import Iterator

import numpy as np

from estimator.model import Model
from estimator.record import Array, Recording

JIG = (("probe", 1.0), ("bar", -1.0))  # what expands, and whether it adds to a reading
EDGE_S = 30.0  # seconds of readings on each side through which a line goes
FEW = 3  # readings; through less there goes no line


def jig_expansion(recording: Recording, model: Model) -> Array:
    """What warm probes add to a reading and a warm bar takes away, (K,) um; 0 where they are not measured."""
    total = np.zeros(len(recording))
    for path, sign, rise in _rises(recording, model, recording.time_s[0]):
        total += sign * model[path] * rise
    return total


def jig_doubt(recording: Recording, model: Model, since_s: float) -> Array:
    """By how much that may be wrong since a time, (K,) um: one sd of coefficients that are not known any better."""
    variance = np.zeros(len(recording))
    for path, _, rise in _rises(recording, model, since_s):
        variance += ((model.values[path].sd or 0.0) * rise) ** 2
    return np.sqrt(variance)


def _rises(recording: Recording, model: Model, since_s: float) -> Iterator[tuple[str, float, Array]]:
    """Coefficient, sign and rise since a time, (K,) K, 0 where it is not known, of what the model knows to expand."""
    for name, sign in JIG:
        column, path = recording.inputs.get(name), f"displacement.{name}"
        if column is not None and path in model.values:
            since = column[np.isfinite(column) & (recording.time_s >= since_s)]
            yield path, sign, np.nan_to_num(column - since[0]) if len(since) else np.zeros(len(column))


def levels(time_s: Array, reading: Array, at_s: Array) -> tuple[Array, Array]:
    """Lines through the readings of half a minute on each side of times, at these times; the nearest where there are
    few. And their variance over that of one reading.

    time_s (n,);   reading (n,), or (n, k) of k at the same times;   at_s (m,)
    """
    apart, at = time_s - time_s[0], at_s - time_s[0]
    begins, ends = np.searchsorted(apart, at - EDGE_S), np.searchsorted(apart, at + EDGE_S, side="right")
    turned = reading.T

    def total(values: Array) -> Array:
        sums = np.concatenate([np.zeros_like(values[..., :1]), np.cumsum(values, axis=-1)], axis=-1)
        return np.asarray(sums[..., ends] - sums[..., begins])

    few = ends - begins < FEW
    n = np.maximum(ends - begins, 1)
    middle = total(apart) / n
    spread = np.where(few, 1.0, total(apart**2) - n * middle**2)
    slope = (total(apart * turned) - middle * total(turned)) / spread
    line = (total(turned) / n + slope * (at - middle)).T
    nearest = np.searchsorted((apart[1:] + apart[:-1]) / 2, at)
    line[few] = reading[nearest[few]]
    return line, np.where(few, 1.0, 1.0 / n + (at - middle) ** 2 / spread)
