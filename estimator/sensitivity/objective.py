"""What an open-loop misfit weighs and how it moves with a parameter: one least-squares objective for every search.

    sum over runs, ticks, channels of w (misfit / s)^2  +  sum over parameters of ((p - p0) / sd)^2

s is the misfit that a good model leaves, not the sensors' scatter: such a misfit stays alike until the rig has
forgotten it, so that a block of that length (`Trial.block_s`) weighs as much as one independent reading. It spans many
thermometers as well, so that all of them on the screw, or on one body, together weigh as much as one. Else what they
have in common would overrun every table value, and temperatures a thousandth of a kelvin closer outweigh an elongation
twice as far off.
"""

from collections.abc import Iterable

import numpy as np

from estimator.effect import Param
from estimator.record import Array
from estimator.rig import Rig

GOOD_K, GOOD_UM = 0.05, 0.2  # s of a thermometer, of the displacement


def good(rig: Rig) -> Array:
    """s: the misfit of each channel that a good model leaves, K or um, (m,)."""
    return np.where(rig.is_thermometer, GOOD_K, GOOD_UM)


def weights(rig: Rig, block_s: float) -> Array:
    """w: what one reading of each channel counts, in independent readings, (m,)."""
    heat = rig.is_thermometer
    return np.where(heat, bodies_read(rig) / max(heat.sum(), 1), 1.0) * rig.tick_s / block_s


def bodies_read(rig: Rig) -> int:
    """How many bodies thermometers are on, the screw one of them: what each misses of heat is its own."""
    return len(rig.bodies) + bool(np.isfinite(rig.x_mm).any())


def prior_roots(params: Iterable[Param]) -> Array:
    """1 / sd of each parameter's prior, (p,); 0 for none."""
    return np.array([1 / param.sd if param.sd else 0.0 for param in params])
