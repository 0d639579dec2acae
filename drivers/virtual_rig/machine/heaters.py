"""Planted sources of heat on the screw: the motor behind its coupling, and a local place."""

from dataclasses import dataclass

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.machine.geometry import OMEGA_20, SCREW_MM
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.machine.screw import overlap
from drivers.virtual_rig.population.constants import Sources

MOTOR_W = 15.0  # through the coupling into the end of the screw, while driving
LOCAL_W = 1.5
LOCAL_DRIVING_W = 2.0
RUBBING_W = 6.0  # at 20 m/min
CHIPS_W = 1.5
BLAST_W = -8.0
LOCAL_RANGE_MM = (150.0, 780.0)


@dataclass(frozen=True)
class Heaters:
    """Heat into each cell (W): always, driving, at reference speed (~ omega^2), at rest, just stopped.

    `places` says where the local ones sit, mm.
    """

    always: np.ndarray
    driving: np.ndarray
    rubbing: np.ndarray
    resting: np.ndarray
    stopped: np.ndarray
    fading_s: float
    places: dict[str, float]

    def heat(self, omega: np.ndarray, moving: np.ndarray, since_stop_s: float) -> np.ndarray:
        """W into each cell over a tick, from the speeds (rad/s) and motion of its steps; negative: never moved"""
        share = moving.mean()
        rested = (1.0 - share) * (since_stop_s >= 0.0)
        fading = rested * np.exp(-max(since_stop_s, 0.0) / self.fading_s)
        rubbing = self.rubbing * ((omega / OMEGA_20) ** 2).mean()
        return self.always + self.driving * share + rubbing + self.resting * rested + self.stopped * fading


def heaters(seed: int, strength: Strengths, sources: Sources) -> Heaters:
    """The planted sources at their strengths, with a machine's widths; the places depend on the seed alone."""
    watts = {
        "local_heat": LOCAL_W,
        "local_heat_driving": LOCAL_DRIVING_W,
        "rubbing_cover": RUBBING_W,
        "parked_chips": CHIPS_W,
        "stop_blast": BLAST_W,
    }
    places = {name: local_place(seed, name) for name in watts}
    motor = _spot(SCREW_MM[1] - sources.motor_width / 2.0, sources.motor_width) * MOTOR_W * strength["motor_heat"]
    local = {name: _spot(x, sources.local_width) * watts[name] * strength[name] for name, x in places.items()}
    return Heaters(
        always=local["local_heat"],
        driving=motor + local["local_heat_driving"],
        rubbing=local["rubbing_cover"],
        resting=local["parked_chips"],
        stopped=local["stop_blast"],
        fading_s=sources.blast_fading,
        places={name: x for name, x in places.items() if strength[name]},
    )


def local_place(seed: int, name: str) -> float:
    """Centre of a local source, mm"""
    return float(round(dice(seed, name).uniform(*LOCAL_RANGE_MM)))


def _spot(centre_mm: float, width_mm: float) -> np.ndarray:
    share = overlap(centre_mm - width_mm / 2.0, centre_mm + width_mm / 2.0)
    return share / share.sum()
