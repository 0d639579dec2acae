"""Planted sources of heat on the screw: the motor behind its coupling, and local places."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.machine.drawn import DRAWN, Drawn, drawn
from drivers.virtual_rig.machine.geometry import SCREW_MM
from drivers.virtual_rig.machine.motion import Pace
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.machine.screw import CELL_MM, overlap
from drivers.virtual_rig.population.constants import Sources

MOTOR_W = 15.0  # through the coupling into the end of the screw, while driving
WEDGE_MM = 160.0  # of a place that is strongest at its motor end and fades towards the other
LOCAL_RANGE_MM = (150.0, 780.0)


class Source(NamedTuple):
    """A local source: W at strength 1 and a factor of 1, the factor in time, whether it is a wedge"""

    watts: float
    factor: Callable[[Pace], float]
    wedge: bool = False


LOCAL = {
    "local_heat": Source(1.5, lambda pace: 1.0),
    "local_heat_driving": Source(2.0, lambda pace: pace.share),
    "rubbing_cover": Source(6.0, lambda pace: pace.power(2.0)),
    "parked_chips": Source(1.5, lambda pace: pace.rested),
    "stop_blast": Source(-8.0, lambda pace: pace.fading(pace.fading_s)),
    "rubbing_wiper": Source(6.0, lambda pace: pace.power(1.5)),
    "wide_jet": Source(-6.0, lambda pace: pace.power(1.0), wedge=True),
    "slow_blast": Source(-6.0, lambda pace: pace.fading(900.0)),
    "start_surge": Source(20.0, lambda pace: pace.share * math.exp(-pace.since_start_s / 120.0)),
    "slow_soak": Source(3.0, lambda pace: pace.rested - pace.fading(1200.0)),
}


@dataclass(frozen=True)
class Heaters:
    """What is planted: the motor's heat into each cell while driving, W, and by name that of each local source at a
    factor of 1.

    `places` says where the local ones sit, mm; `drawn`: the law of one whose shape is drawn.
    """

    motor: np.ndarray
    local: dict[str, np.ndarray]
    fading_s: float
    places: dict[str, float]
    drawn: Drawn

    def heat(self, omega: np.ndarray, moving: np.ndarray, since_stop_s: float, since_start_s: float) -> np.ndarray:
        """W into each cell over a tick, from speeds (rad/s) and motion of its steps; times as in Pace"""
        pace = Pace(omega, float(moving.mean()), since_stop_s, since_start_s, self.fading_s)
        total = self.motor * pace.share
        for name, cells in self.local.items():
            total = total + cells * (self.drawn.factor(pace) if name == DRAWN else LOCAL[name].factor(pace))
        return total


def heaters(seed: int, strength: Strengths, sources: Sources) -> Heaters:
    """The planted sources at their strengths, with a machine's widths; the places depend on the seed alone."""
    places = {name: local_place(seed, name) for name in LOCAL if strength[name]}
    motor = _spot(SCREW_MM[1] - sources.motor_width / 2.0, sources.motor_width)
    local = {
        name: (_wedge(x) if LOCAL[name].wedge else _spot(x, sources.local_width)) * LOCAL[name].watts * strength[name]
        for name, x in places.items()
    }
    shape = drawn(seed)
    if strength[DRAWN]:
        places |= {DRAWN: shape.place_mm}
        local |= {DRAWN: _spot(shape.place_mm, shape.width_mm) * shape.watts * strength[DRAWN]}
    return Heaters(motor * MOTOR_W * strength["motor_heat"], local, sources.blast_fading, places, shape)


def local_place(seed: int, name: str) -> float:
    """Centre of a local source's heat, mm"""
    return float(round(dice(seed, name).uniform(*LOCAL_RANGE_MM)))


def _spot(centre_mm: float, width_mm: float) -> np.ndarray:
    share = overlap(centre_mm - width_mm / 2.0, centre_mm + width_mm / 2.0)
    return share / share.sum()


def _wedge(centre_mm: float) -> np.ndarray:
    """Grows evenly over its width, of which two thirds lie before its centre."""
    before = CELL_MM - (centre_mm - 2.0 / 3.0 * WEDGE_MM)
    share = np.where((before > 0.0) & (before < WEDGE_MM), before, 0.0)
    return share / share.sum()
