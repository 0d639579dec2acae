"""Whether what is followed can drive heat at a place: a temperature far away cannot, but for air, base and coolant."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimator.inputs.follower import Follower
from estimator.missing_heat.zones import Zone
from estimator.rig import Rig

REACH_MM = 200.0  # within which a temperature may drive heat: diffusion, sqrt(4 a t), in ten minutes
READS = ("probe", "bar", "board")  # what reads: it warms beside the screw and gives it no heat


def reaches(follower: Follower, rig: Rig, zones: Sequence[Zone]) -> bool:
    """Whether a follower can drive heat in some zones together.

    A temperature of a support, an input that has its name ("anchor_bracket"), only near that support.
    """
    if follower.name not in rig.inputs:
        return True
    if follower.name in READS:
        return False
    at = next((support.at_mm for name, support in rig.supports.items() if follower.name.startswith(name)), None)
    places = [place for zone in zones for place in (zone.from_mm, zone.to_mm) if place is not None]
    if at is None or not places:
        return True
    return bool(np.min(places) - REACH_MM <= at <= np.max(places) + REACH_MM)
