"""Bodies that have a thermometer, the nut and the bearings' brackets: how far the open-loop run is from what it shows.

The thermometer tells what a body starts with, and then, less its own unknown zero, how the body goes on. It sits at one
place of a body that the model has as one lump, and shows an unknown share more or less of how the lump rises: it is no
channel of the filter, but a fit hears when a body rises, and about how far.
"""

from __future__ import annotations

import numpy as np

from estimator.batch.trial import Posed, Trial
from estimator.faults.fault import Fault
from estimator.record import Array
from estimator.terms import Store

LUMP_K = 0.1  # sd of what a body is off by at its thermometer though the model is right, beside ...
LUMP_SHARE = 0.1  # ... the same of the share by which that shows too much of a rise


def measured_bodies(posed: Posed) -> dict[int, str]:
    """State of each body with a thermometer, and the input that this is."""
    place, rig = posed.forcing.place, posed.forcing.rig
    stores = [term for term in posed.forcing.terms if isinstance(term, Store) and term.node in place.bodies]
    return {place.state(term.node): term.start for term in stores if term.start and term.start in rig.inputs}


def body_misfit(trial: Trial, posed: Posed) -> Array:
    """Thermometer of each measured body minus the body by the model alone, (T, bodies) K; NaN where it says nothing."""
    return shown(trial, posed) - _less_zero(posed.run.z[1:, list(measured_bodies(posed))], trial, posed)


def shown(trial: Trial, posed: Posed) -> Array:
    """What these thermometers show, (T, bodies) K, less their mean; NaN where nothing."""
    inputs, names = trial.drive.inputs.rows(slice(1, None)), measured_bodies(posed).values()
    return _less_zero(np.hstack([np.empty((len(inputs), 0)), *(inputs[name] for name in names)]), trial, posed)


def body_slope(z: Array, trial: Trial, posed: Posed) -> Array:
    """How the bodies of `body_misfit` move with a parameter by which the states move so, z (T, n)."""
    return _less_zero(z[:, list(measured_bodies(posed))], trial, posed)


def _less_zero(values: Array, trial: Trial, posed: Posed) -> Array:
    """Values (T, bodies) where the thermometer was read and is well, less their mean; none where it never moves."""
    names = list(measured_bodies(posed).values())
    known = np.reshape([_well(trial, name) for name in names], (len(names), len(values))).T
    mean = np.where(known, values, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    return np.where(known, values - mean, np.nan)


def _well(trial: Trial, name: str) -> Array:
    """Where an input was read and is well, (T,) bool."""
    read, fault = trial.rest.inputs[name], trial.drive.inputs.fault[1:, list(trial.rig.inputs).index(name)]
    well = np.isfinite(read) & (fault == Fault.NONE)
    return np.asarray(well & (read.min(initial=np.inf, where=well) < read.max(initial=-np.inf, where=well)))


class Lumps:
    """Weighs misfits of bodies that have shown r (K, bodies), NaN: nothing, as least squares take them.

    Errors of a body have the covariance C = s^2 I + share^2 r r'; C^-1/2 takes off all but a part of what is along r.

    off    (K, bodies) what a model at hand leaves: s is its rms, and at least LUMP_K
    steps  of K that say the same
    """

    def __init__(self, shown: Array, off: Array, steps: float) -> None:
        count = np.maximum(np.isfinite(off).sum(axis=0), 1)
        self.sd_K = np.maximum(np.sqrt(np.nan_to_num(off**2).sum(axis=0) / count), LUMP_K)
        self._weight = 1.0 / (self.sd_K * np.sqrt(steps))
        self._along = np.nan_to_num(shown) * self._weight
        square = (self._along**2).sum(axis=0)
        self._part = (1.0 - 1.0 / np.sqrt(1.0 + LUMP_SHARE**2 * square)) / np.maximum(square, 1e-300)

    def white(self, values: Array) -> Array:
        """C^-1/2 v of each body's v, (K, bodies); NaN counts nothing."""
        white = np.nan_to_num(values) * self._weight
        return np.asarray(white - self._along * (self._part * (self._along * white).sum(axis=0)))
