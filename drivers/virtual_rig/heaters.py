"""Planted sources of heat on the screw: the motor behind its coupling, and a local place."""

from dataclasses import dataclass

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.geometry import SCREW_MM
from drivers.virtual_rig.planted import Strengths
from drivers.virtual_rig.screw import overlap

MOTOR_W = 15.0
"""through the coupling into the last 40 mm of the screw, while driving"""
MOTOR_MM = 40.0
LOCAL_W = 1.5
LOCAL_DRIVING_W = 2.0
LOCAL_MM = 30.0
LOCAL_RANGE_MM = (150.0, 780.0)


@dataclass(frozen=True)
class Heaters:
    """Heat into each cell (W) always and while driving; `places` says where the local ones sit, mm."""

    always: np.ndarray
    driving: np.ndarray
    places: dict[str, float]


def heaters(seed: int, strength: Strengths) -> Heaters:
    """The planted sources at their strengths; the places depend on the seed alone."""
    places = {name: local_place(seed, name) for name in ("local_heat", "local_heat_driving")}
    motor = _spot(SCREW_MM[1] - MOTOR_MM / 2.0, MOTOR_MM) * MOTOR_W * strength["motor_heat"]
    local = {name: _spot(x, LOCAL_MM) * strength[name] for name, x in places.items()}
    return Heaters(
        always=LOCAL_W * local["local_heat"],
        driving=motor + LOCAL_DRIVING_W * local["local_heat_driving"],
        places={name: x for name, x in places.items() if strength[name]},
    )


def local_place(seed: int, name: str) -> float:
    """Centre of a local source, mm"""
    return float(round(dice(seed, name).uniform(*LOCAL_RANGE_MM)))


def _spot(centre_mm: float, width_mm: float) -> np.ndarray:
    share = overlap(centre_mm - width_mm / 2.0, centre_mm + width_mm / 2.0)
    return share / share.sum()
