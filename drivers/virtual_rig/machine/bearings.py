"""The two support bearings: friction on their seats, and housings that pass the heat on to the machine's base."""

import numpy as np

from drivers.virtual_rig.machine.flows import Bearing
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.machine.screw import overlap
from drivers.virtual_rig.population.constants import Anchor

PALMGREN = 2.0 / 3.0  # of the viscous torque; a law of pure power has one exponent for both
SPEED_EXPONENT = 0.25  # added by bearing_speed_exponent; the heat at 20 m/min stays


def cover(support: Anchor) -> np.ndarray:
    """Share of each cell under the inner ring: (CELLS,)"""
    return overlap(support.centre - support.width / 2.0, support.centre + support.width / 2.0)


def bearing(support: Anchor, name: str, strength: Strengths) -> Bearing:
    """The laws of the support called anchor or free, at the given strengths of its effects."""
    friction, under = strength[f"{name}_friction"], cover(support)
    return Bearing(
        seat=under / under.sum(),
        load_torque=support.load_torque * friction,
        viscous_torque=support.viscous_torque * friction,
        load_exponent=support.power,
        viscous_exponent=support.power or PALMGREN,
        into_screw=support.into_screw,
        contact=support.contact * strength[f"{name}_housing"],
        capacity=support.capacity * (support.ring_share or 1.0),
        to_bracket=support.ring_to_bracket,
        bracket_capacity=support.capacity * (1.0 - support.ring_share),
        to_base=support.to_base,
        to_air=support.to_air,
        thinning=support.thinning + support.planted_thinning * strength["friction_thinning"],
        exponent=SPEED_EXPONENT * strength["bearing_speed_exponent"],
        grease_degc=support.grease,
    )
