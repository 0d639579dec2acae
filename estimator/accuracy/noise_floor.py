"""What the sensors alone leave of an error, and when an error is far above it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator.accuracy.accuracy import rms
from estimator.batch.trial import Trial
from estimator.model import Model
from estimator.record import Array
from estimator.rig import Rig

FAR = 3.0  # an open-loop error this many times the noise floor is missing physics


def noise_floor(model: Model, trial: Trial) -> "Error":
    """What sensors alone would leave of an open-loop error: scatter and unknown zeros of thermometers, of the rest."""
    readings = trial.pose(model).forcing.readings
    heat = trial.rig.is_thermometer
    known = np.isfinite(readings.sd)
    zero = np.where(heat, readings.zero_sd, 0.0)  # that of the displacement is taken out of an open-loop error
    variance = readings.sd**2 + zero**2

    def level(which: np.ndarray) -> float:
        return float(np.sqrt(np.mean(variance[which]))) if which.any() else float("nan")

    return Error(level(heat & known), level(~heat & known))


def missing_physics(open_loop: "Error", floor: "Error") -> float:
    """Open-loop error over the noise floor of the thermometers where it is far above it, else NaN."""
    ratio = open_loop.temperature_K / floor.temperature_K
    return ratio if ratio > FAR else float("nan")


@dataclass(frozen=True)
class Error:
    """An rms over thermometers, K, and of the elongation, um; NaN where there is none."""

    temperature_K: float
    elongation_um: float

    def __str__(self) -> str:
        return f"{self.temperature_K:.3f} K, {self.elongation_um:.2f} um"


def rms_by_family(misfits: Sequence[Array], rig: Rig) -> Error:
    """rms of what models miss on some recordings of a rig, (T, m) each."""
    rest = np.concatenate(misfits)
    return Error(rms(rest[:, rig.is_thermometer]), rms(rest[:, ~rig.is_thermometer]))
