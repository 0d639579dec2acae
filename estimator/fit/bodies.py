"""Bodies that have a thermometer, the nut and the bearings' brackets: how far the open-loop run is from what it shows.

The thermometer tells what a body starts with, and then, less its own unknown zero, how the body goes on. It sits at one
place of a body that the model has as one lump, and shows an unknown share more or less of how the lump rises: it is no
channel of the filter, but a fit hears when a body rises, and about how far.
"""

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
    shown = [term for term in stores if term.shown and term.start in rig.inputs]
    return {place.state(term.node): str(term.start) for term in shown}


def body_misfit(trial: Trial, posed: Posed) -> Array:
    """Thermometer of each measured body minus the body by the model alone, (T, bodies) K; NaN where it says nothing."""
    return shown(trial, posed) - body_slope(posed.run.z[1:], trial, posed)


def shown(trial: Trial, posed: Posed) -> Array:
    """What these thermometers show, (T, bodies) K, less their mean; NaN where nothing."""
    inputs, names = trial.drive.inputs.rows(slice(1, None)), measured_bodies(posed).values()
    return _less_zero(np.hstack([np.empty((len(inputs), 0)), *(inputs[name] for name in names)]), trial, posed)


def body_slope(z: Array, trial: Trial, posed: Posed) -> Array:
    """How the bodies of `body_misfit` move with parameters by which the states move so, z (..., T, n)."""
    return _less_zero(z[..., list(measured_bodies(posed))], trial, posed)


def _less_zero(values: Array, trial: Trial, posed: Posed) -> Array:
    """Values (..., T, bodies) where the thermometer was read and is well, less their mean; none where it is stuck."""
    names = list(measured_bodies(posed).values())
    known = np.reshape([_well(trial, name) for name in names], (len(names), len(trial.rest))).T
    mean = np.where(known, values, 0.0).sum(axis=-2, keepdims=True) / np.maximum(known.sum(axis=0), 1)
    return np.where(known, values - mean, np.nan)


def _well(trial: Trial, name: str) -> Array:
    """Where an input was read and is well, (T,) bool."""
    read, fault = trial.rest.inputs[name], trial.drive.inputs.fault[1:, list(trial.rig.inputs).index(name)]
    well = np.isfinite(read) & (fault == Fault.NONE)
    return np.asarray(well & (read.min(initial=np.inf, where=well) < read.max(initial=-np.inf, where=well)))


class Lumps:
    """Weighs misfits v of bodies that have shown r, as least squares take them.

    Errors of a body have the covariance C = s^2 I + share^2 r r', of which

        u' C^-1 v = (u'v - k (r'u) (r'v)) / s^2        k = share^2 / (s^2 + share^2 r'r)

    count, off, shown  (bodies,) how often each was read, what a model at hand leaves, squared: s is its rms, and at
                       least LUMP_K, and r'r
    steps              of them that say the same
    """

    def __init__(self, count: Array, off: Array, shown: Array, steps: float) -> None:
        self.sd_K = np.maximum(np.sqrt(off / np.maximum(count, 1)), LUMP_K)
        variance = self.sd_K**2 * steps
        self._weight, self._part = 1.0 / variance, LUMP_SHARE**2 / (variance + LUMP_SHARE**2 * shown)

    def products(self, products: Array, along: Array) -> Array:
        """v' C^-1 v of all bodies, (c, c), from v'v (bodies, c, c) and r'v (bodies, c) of c columns v."""
        taken = (self._part[:, None] * along)[:, :, None] * along[:, None, :]
        return np.asarray((self._weight[:, None, None] * (products - taken)).sum(axis=0))
