"""Heat that no effect of the model stands for, at one place: what it does to thermometers along the screw."""

import numpy as np

from estimator.record import Array
from estimator.screw import Screw

HEAT_W = 10.0  # more than is left unsaid of a machine
BEFORE_S = (100.0, 300.0, 1000.0)  # for how long it may have been there
LATE = 0.6  # of the time, for which heat that begins with it is there at least
BEGINS = 3  # of the heats at a place, those that begin


def local_heats(x_mm: Array, screw: Screw | None, seconds: float) -> Array:
    """By how much thermometers at x_mm (m,), NaN: beside the screw, change in so many seconds, (m, h, m) K, by HEAT_W
    at each or half way to one of the next: the BEGINS that begin soon, those that have been there before and go on,
    and those that end."""
    if screw is None:
        return np.zeros((len(x_mm), BEGINS, len(x_mm)))
    away = x_mm - x_mm[:, None]
    next_mm = [np.nanmin(np.where(side * away > 0, side * away, np.inf), axis=1) for side in (-1, 1)]
    halves = [np.where(np.isfinite(mm), side * mm / 2, 0.0) for side, mm in zip((-1, 1), next_mm, strict=True)]
    away = away[:, None] - np.stack([np.zeros(len(x_mm)), *halves], axis=1)[:, :, None]
    begins = screw.warmed(away, LATE * seconds)
    goes_on = [screw.warmed(away, seconds + before) - screw.warmed(away, before) for before in BEFORE_S]
    return HEAT_W * np.concatenate([begins, *goes_on, *(on - screw.warmed(away, seconds) for on in goes_on)], axis=1)
