"""How far readings are from what the model alone says, from the first sample on."""

import numpy as np

from estimator.batch.trial import Posed, Trial
from estimator.record import Array


def open_loop_misfit(trial: Trial, posed: Posed) -> Array:
    """Reading minus what the model alone says, (T, m); NaN where not measured; unknown zeros taken out."""
    run = posed.run
    rest = trial.rest.channels - posed.offset[1:] - run.lagged - run.late - posed.state.channel_zeros(posed.system.x0)
    return where_measured(rest, trial)


def where_measured(values: Array, trial: Trial) -> Array:
    """Values (..., T, m) where a reading was taken and fused, else NaN; less their mean where a zero has no meaning."""
    taken = measured(trial)
    values = np.where(taken, values, np.nan)
    for channel in trial.floating:
        if (at := np.flatnonzero(taken[:, channel])).size:
            values[..., channel] -= values[..., at, channel].mean(axis=-1, keepdims=True)
    return values


def measured(trial: Trial) -> Array:
    """Which readings were taken, and are neither muted nor refused, (T, m) bool."""
    return np.isfinite(trial.rest.channels) & ~trial.muted
