"""Where heat may be missing: stretches of the screw, and the bodies that thermometers read."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from estimator.network.assemble import spread
from estimator.network.layout import Layout
from estimator.record import Array
from estimator.rig import Rig
from estimator.terms import SCREW

ZONE_MM = 50.0  # about
ALIKE_MM = 150.0  # heat stays alike over such a distance


@dataclass(frozen=True)
class Zone:
    """A stretch of the screw, or a body (`node`, without places).

    length_m  by which W/m become W; 1 for a body, whose heat is in W
    """

    from_mm: float | None
    to_mm: float | None
    node: str | None
    length_m: float

    @property
    def middle_mm(self) -> float:
        """Where it is along the screw; NaN for a body."""
        return float("nan") if self.from_mm is None or self.to_mm is None else (self.from_mm + self.to_mm) / 2


def zones(rig: Rig, place: Layout) -> tuple[Zone, ...]:
    """Equal stretches of the screw from end to end, then the bodies that thermometers read."""
    found: list[Zone] = []
    if rig.screw and SCREW in place.nodes:
        lo, hi = rig.screw.from_mm, rig.screw.to_mm
        edges = np.linspace(lo, hi, max(1, round((hi - lo) / ZONE_MM)) + 1).tolist()
        found += [Zone(a, b, None, (b - a) * 1e-3) for a, b in pairwise(edges)]
    return (*found, *(Zone(None, None, node, 1.0) for node in rig.bodies if node in place.nodes))


def heat_of(zone: Zone, rig: Rig, place: Layout) -> Array:
    """W into the states, (n,), from 1 W/m along the zone, or 1 W into the body."""
    if zone.node is not None or zone.from_mm is None or zone.to_mm is None:
        return np.asarray(place.rows(str(zone.node))[0])
    screw = rig.the_screw()
    return np.asarray(spread(1.0, screw.overlap(zone.from_mm, zone.to_mm) * screw.length, place.rows(SCREW))[0])


def alike(found: tuple[Zone, ...]) -> Array:
    """Correlation (zones, zones) of heats smooth along the screw: exp(-distance / 150 mm).

    The heats of bodies are independent of each other and of the screw's.
    """
    at = np.array([zone.middle_mm for zone in found])
    near = np.exp(-np.abs(at[:, None] - at) / ALIKE_MM)
    return np.where(np.isfinite(near), near, np.eye(len(found)))
