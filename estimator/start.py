"""The start of a run: from the first sample, what is warm, what is steady, and how well it is known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from estimator.assemble import Layout, Readings
from estimator.record import Array, Sample
from estimator.regime import AT_REST
from estimator.rig import Rig
from estimator.terms import Store, Term

UNIFORM_K = 0.2  # a rig whose thermometers agree so well at rest has been waiting long enough to be steady
SENSOR_K = 1.5  # the most that other thermometers of a steady rig can differ from the screw's by their own error
LEVEL_SD_K = 5.0
BODY_SD_K = 0.3
UNKNOWN_BODY_SD_K = 2.0
SMOOTH_MM = 200.0


@dataclass(frozen=True)
class Start:
    """What the first sample says.

    level_C   mean of the thermometers
    spread_K  highest minus lowest
    zero_K    what is taken off each temperature input: in a steady rig all are in equilibrium with the screw, so that a
              difference is either a sensor's error or a flow that has been there all along; 0 otherwise
    """

    level_C: float
    spread_K: float
    zero_K: Mapping[str, float]


def read_start(sample: Sample, rig: Rig) -> Start | None:
    """Start from this sample, or None while no thermometer has been read."""
    temperatures = sample.channels[[rig.index(name) for name in rig.thermometers]]
    known = temperatures[np.isfinite(temperatures)]
    if not len(known):
        return None
    level, spread = float(known.mean()), float(np.ptp(known))
    steady = spread <= UNIFORM_K and not sample.omega > AT_REST
    zero = {}
    for name, signal in rig.inputs.items():
        difference = sample.inputs.get(name, np.nan) - level
        near = np.isfinite(difference) and abs(difference) <= SENSOR_K
        zero[name] = float(difference) if signal.unit == "degC" and steady and near else 0.0
    return Start(level, spread, zero)


def prior(start: Start, terms: list[Term], place: Layout, inputs: Mapping[str, float]) -> tuple[Array, Array]:
    """Mean (n,) and covariance (n, n) of the states before the first reading.

    Along the screw the profile is the level plus a smooth deviation as large as the spread of the thermometers
    (a Gaussian process with 200 mm correlation length), so that the first readings interpolate between themselves.
    """
    n, knots = place.size, len(place.knots_mm)
    mean, cov = np.full(n, start.level_C), np.zeros((n, n))
    apart = place.knots_mm[:, None] - place.knots_mm[None, :]
    deviation = max(0.02, start.spread_K)
    cov[:knots, :knots] = LEVEL_SD_K**2 + deviation**2 * np.exp(-0.5 * (apart / SMOOTH_MM) ** 2)
    cov[np.arange(knots), np.arange(knots)] += (0.05 * deviation) ** 2
    for term in terms:
        if isinstance(term, Store) and term.node in place.bodies:
            i = place.state(term.node)
            reading = inputs.get(term.start, np.nan) if term.start else np.nan
            mean[i] = reading if np.isfinite(reading) else start.level_C
            cov[i, i] = (BODY_SD_K if np.isfinite(reading) else UNKNOWN_BODY_SD_K) ** 2
    return mean, cov


def known_thermometers(sample: Sample, rig: Rig, readings: Readings) -> Array:
    """Indices of the thermometers read in this sample that the model has a row for."""
    at = np.array([rig.index(name) for name in rig.thermometers], dtype=int)
    return at[np.isfinite(sample.channels[at]) & np.isfinite(readings.sd[at])]
