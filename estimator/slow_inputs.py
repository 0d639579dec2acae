"""Temperatures beside the screw on a run that was never made: probes, bar, board, brackets.

    dr/dt = a m + c w - b r,   r the rise of the input, m the mean rise of the thermometers, w the speed

with a, b, c by least squares on the integrals over the recordings at hand, so that noise is not differentiated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.signal import lfilter

from estimator.record import Array, Recording
from estimator.rig import Rig


def learned(recordings: Sequence[Recording], rig: Rig) -> dict[str, Array]:
    """(a, c, b) of every temperature that is an input, in 1/s."""
    return {name: _law(recordings, rig, name) for name, signal in rig.inputs.items() if signal.unit == "degC"}


def foretold(laws: Mapping[str, Array], mean_rise: Array, omega: Array, tick_s: float) -> dict[str, Array]:
    """Rise of each input, (K,), on a run with this mean rise of the thermometers and this speed."""
    out = {}
    for name, (a, c, b) in laws.items():
        drive = (a * mean_rise + c * omega) * tick_s
        out[name] = lfilter([1.0], [1.0, -np.exp(-max(b, 0.0) * tick_s)], drive)
    return out


def _law(recordings: Sequence[Recording], rig: Rig, name: str) -> Array:
    rows, rises = [], []
    heat = [rig.index(each) for each in rig.thermometers]
    for recording in recordings:
        r, m = _rise(recording.inputs[name]), np.nan_to_num(_rise(np.nanmean(recording.channels[:, heat], axis=1)))
        sums = np.cumsum([m, np.nan_to_num(recording.omega), -np.nan_to_num(r)], axis=1) * rig.tick_s
        known = np.isfinite(r)
        rows.append(sums[:, known].T)
        rises.append(r[known])
    stacked = np.concatenate(rows)
    if not len(stacked):
        return np.zeros(3)
    return np.asarray(np.linalg.lstsq(stacked, np.concatenate(rises), rcond=None)[0])


def _rise(column: Array) -> Array:
    known = column[np.isfinite(column)]
    return column - (known[:10].mean() if len(known) else np.nan)
