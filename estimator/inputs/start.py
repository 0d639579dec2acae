"""The start of a run: from the first sample, what is warm, what is steady, and how well it is known."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from estimator.inputs.phase import turns
from estimator.record import POWER_ON_C, Array, Sample
from estimator.rig import Rig

UNIFORM_K = 0.1  # a rig whose thermometers agree so well at rest has been waiting long enough to be steady ...
WARM_K = 0.2  # ... and one whose thermometers differ by so much has not; between both it is partly so
SENSOR_K = 1.5  # the most that other thermometers of a steady rig can differ from the screw's by their own error
AIR = "ambient"
ODD_K = 10.0  # further from the median than any part of a screw gets: no temperature


@dataclass(frozen=True)
class Start:
    """What the first sample says.

    level_C   median of the thermometers
    spread_K  highest minus lowest of those that are within 10 K of it; of all where none is
    zero_K    what is taken off each temperature input: in a steady rig all are in equilibrium with the screw, so that a
              difference is either a sensor's error or a flow that has been there all along; 0 in a warm rig, and in
              proportion between both, so that a hundredth of a kelvin does not decide
    above_K   how much warmer than the air the screw is; 0 in a steady rig, and where nothing credible tells
    """

    level_C: float
    spread_K: float
    zero_K: Mapping[str, float]
    above_K: float = 0.0

    def sets_right(self, told_C: float) -> bool:
        """Whether an input that tells so at the start is taken for one with an error of its own, at least in part."""
        return self.spread_K < WARM_K and abs(told_C - self.level_C) <= SENSOR_K


def read_start(sample: Sample, rig: Rig, muted: Array | None = None) -> Start | None:
    """Start from this sample, or None while no thermometer has been read. `muted` (m,) bool: channels to leave out.

    Where more than one says exactly what thermometers say after power-on, these have not been read yet.
    """
    muted = np.zeros(len(rig.names), dtype=bool) if muted is None else muted
    at = np.array([rig.index(name) for name in rig.thermometers], dtype=int)
    known = sample.channels[at][np.isfinite(sample.channels[at]) & ~muted[at]]
    asleep = np.isin(known, POWER_ON_C)
    if asleep.sum() > 1:
        known = known[~asleep]
    if not len(known):
        return None
    level = float(np.median(known))
    apart = np.abs(known - level)
    near = known[apart <= ODD_K]
    spread = float(np.ptp(near if len(near) else known))
    others = np.delete(known, apart.argmax()) if len(known) > 2 else known  # one may be a spike
    steady = float(np.clip((WARM_K - np.ptp(others)) / (WARM_K - UNIFORM_K), 0.0, 1.0)) * (not turns(sample.omega))
    zero = {}
    for name, signal in rig.inputs.items():
        difference = sample.inputs.get(name, np.nan) - level
        near = np.isfinite(difference) and abs(difference) <= SENSOR_K
        zero[name] = steady * float(difference) if signal.unit == "degC" and near else 0.0
    above = level - sample.inputs.get(AIR, np.nan)
    return Start(level, spread, zero, (1.0 - steady) * above if 0.0 < above <= ODD_K else 0.0)
