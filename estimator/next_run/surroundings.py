"""How temperatures that are inputs would go on a run that was not made yet: as they went on those that were.

    dT/dt = a (mean rise of the thermometers) + c omega - b (T - T(0))

fitted to the recordings at hand; an input of which this explains less than half stays where it is.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from estimator.batch.kernels import coast
from estimator.record import Array, Recording
from estimator.rig import Rig

EXPLAINED = 0.5  # of an input's squares, from which on a law is believed


def learned(recordings: Sequence[Recording], rig: Rig) -> dict[str, Array]:
    """(a, c, b) of every temperature that is an input, in 1/s."""
    return {name: _law(recordings, rig, name) for name, signal in rig.inputs.items() if signal.unit == "degC"}


def foretold(laws: Mapping[str, Array], mean_rise: Array, omega: Array, tick_s: float) -> dict[str, Array]:
    """Rise of each input, (K,), on a run with this mean rise of the thermometers and this speed."""
    out = {}
    for name, (a, c, b) in laws.items():
        drive = (a * mean_rise + c * omega) * tick_s
        kept = np.full((1, 1, 1), np.exp(-max(b, 0.0) * tick_s))
        out[name] = coast(kept, np.zeros(len(drive)), drive[:, None], np.zeros(1))[:, 0]
    return out


def mean_temperature(run: Recording, rig: Rig) -> Array:
    """Mean of the thermometers that were read, (K,) degC; where none was, between those before and after."""
    channels = run.channels[:, rig.is_thermometer]
    read = np.flatnonzero(np.isfinite(channels).any(axis=1))
    return np.interp(np.arange(len(channels)), read, np.nanmean(channels[read], axis=1))


def mean_rise(run: Recording, rig: Rig) -> Array:
    """How far that is above its first, (K,) K."""
    mean = mean_temperature(run, rig)
    return mean - mean[0]


def _law(recordings: Sequence[Recording], rig: Rig, name: str) -> Array:
    rows, rises = [], []
    for recording in recordings:
        r, m = _rise(recording.inputs[name]), _rise(mean_temperature(recording, rig))
        sums = np.cumsum([m, np.nan_to_num(recording.omega), -np.nan_to_num(r)], axis=1) * rig.tick_s
        known = np.isfinite(r)
        rows.append(sums[:, known].T)
        rises.append(r[known])
    stacked, rise = np.concatenate(rows), np.concatenate(rises)
    if not len(stacked):
        return np.zeros(3)
    law = np.asarray(np.linalg.lstsq(stacked, rise, rcond=None)[0])
    left = rise - stacked @ law
    return law if left @ left < (1 - EXPLAINED) * (rise @ rise) else np.zeros(3)


def _rise(column: Array) -> Array:
    known = column[np.isfinite(column)]
    return column - (known[:10].mean() if len(known) else np.nan)
