"""Whether what is followed can drive heat at a place: a temperature far away cannot, but for air, base and coolant."""

from collections.abc import Sequence

from estimator.inputs.follower import Follower
from estimator.rig import Rig

REACH_MM = 200.0  # within which a temperature may drive heat: diffusion, sqrt(4 a t), in ten minutes
READS = ("probe", "bar", "board")  # what reads: it warms beside the screw and gives it no heat


def reaches(follower: Follower, rig: Rig, places_mm: Sequence[float]) -> bool:
    """Whether a follower can drive heat between these places of the screw; none: in a body.

    A temperature of a support, an input that has its name ("anchor_bracket"), only near that support.
    """
    if follower.name not in rig.inputs:
        return True
    if follower.name in READS:
        return False
    at = next((support.at_mm for name, support in rig.supports.items() if follower.name.startswith(name)), None)
    if at is None or not places_mm:
        return True
    return bool(min(places_mm) - REACH_MM <= at <= max(places_mm) + REACH_MM)
