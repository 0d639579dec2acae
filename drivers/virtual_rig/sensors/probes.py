"""The displacement unit: two pairs of capacitance probes against the discs, peak hold and direct reading."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.machine.geometry import ANCHOR_BEARING_MM, LEAD_MM, nut_centre_mm
from drivers.virtual_rig.machine.motion import Stroke, TableMotion
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.machine.screw import AREA_M2, YOUNG_PA
from drivers.virtual_rig.population.constants import Sensors

RANGE_UM = 50.0
OK, UNDER_RANGE, OVER_RANGE = 0, 1, 2
START_UM = (10.0, 1.0)  # gaps set before the run at the motor and the free side
WOBBLE_UM = (0.5, 0.6)  # once a turn, amplitude of each sum
NOISE_UM = 0.1  # sd of the elongation read
HOLD_ERROR_UM = 0.19  # largest loss of a held peak
EXTRA = 2.0  # planted: probes or bar expand by twice their own coefficient more
YIELD_UM_PER_K = 0.54  # planted: the anchor's support moves the motor-side probes as it warms
TABLE_KG = 250.0
TAPE_MM = 18.0
HOLD_TURNS = 1.3  # the peak hold opens at the tape's edge and is frozen 1.3 turns later


class Gauge(NamedTuple):
    """What the readings follow, each (n,): growth at both sides (um), rises of probes, bar and anchor seat (K)"""

    motor_um: np.ndarray
    free_um: np.ndarray
    probe: np.ndarray
    bar: np.ndarray
    seat: np.ndarray


class Reading(NamedTuple):
    """Sums of both probe pairs (um, (n,)) and the unit's state: 0 in range, 1 under, 2 over"""

    a1b1: np.ndarray
    a2b2: np.ndarray
    state: np.ndarray

    @property
    def elongation_um(self) -> np.ndarray:
        """A1B1 / 2 + A2B2 / 2   um"""
        return (self.a1b1 + self.a2b2) / 2.0


@dataclass(frozen=True)
class Probes:
    """Errors of the displacement unit at the strengths of one run; pairs are (motor side, free side)."""

    wobble: np.ndarray
    phase: np.ndarray
    noise: float
    hold_error: float
    inertia: float
    per_probe: float
    per_bar: float
    per_seat: float

    def still(self, gauge: Gauge) -> np.ndarray:
        """Sums without wobble and noise: growth twice at either side, with probe, bar and support errors: (n, 2) um"""
        probe = self.per_probe * gauge.probe
        motor = 2.0 * (gauge.motor_um + self.per_seat * gauge.seat) + probe
        free = 2.0 * (gauge.free_um - self.per_bar * gauge.bar) + probe
        return np.column_stack([motor, free]) + 2.0 * np.array(START_UM)

    def direct(self, gauge: Gauge, motion: TableMotion, draw: np.random.Generator) -> Reading:
        """The sums as they stand, with the wobble of the present angle and the pull of the table's inertia."""
        turning = self.wobble * np.cos(motion.turn_angle[:, None] + self.phase)
        sums = self.still(gauge) + turning + self._scatter(len(turning), draw)
        sums[:, 1] -= 2.0 * self.inertia * _inertia_um(motion)
        return _in_range(sums)

    def held(self, gauge: Gauge, draw: np.random.Generator) -> Reading:
        """The peaks over a turn at the stroke centre, held a little below their true height."""
        n = len(gauge.motor_um)
        loss = self.hold_error * draw.uniform(0.0, 1.0, (n, 2))
        return _in_range(self.still(gauge) + self.wobble - loss + self._scatter(n, draw))

    def _scatter(self, n: int, draw: np.random.Generator) -> np.ndarray:
        return self.noise * np.sqrt(2.0) * draw.standard_normal((n, 2))


def probes(seed: int, strength: Strengths, sensors: Sensors) -> Probes:
    """The unit of this seed's rig; the wobble's phase stays the same from run to run."""
    base = strength["displacement"]
    return Probes(
        wobble=base * np.array(WOBBLE_UM),
        phase=dice(seed, "wobble").uniform(0.0, 2.0 * np.pi, 2),
        noise=base * NOISE_UM,
        hold_error=base * HOLD_ERROR_UM,
        inertia=base,
        per_probe=sensors.probe_um_per_K * (base + EXTRA * strength["probe_expansion"]),
        per_bar=sensors.bar_um_per_K * (base + EXTRA * strength["bar_expansion"]),
        per_seat=YIELD_UM_PER_K * strength["support_yield"],
    )


def freeze_delay_s(stroke: Stroke) -> float:
    """From the stroke centre to the instant at which the peak is frozen: (1.3 turns - half a tape) / v   s"""
    return (HOLD_TURNS * LEAD_MM - TAPE_MM / 2.0) / stroke.speed_mm_s


def _inertia_um(motion: TableMotion) -> np.ndarray:
    """m a (x_anchor - x_nut) / (E A): the screw between nut and anchor gives way   um"""
    arm = ANCHOR_BEARING_MM - nut_centre_mm(motion.position_mm)
    return TABLE_KG * motion.acceleration_mm_s2 * 1e-3 * arm * 1e-3 / (YOUNG_PA * AREA_M2) * 1e6


def _in_range(sums: np.ndarray) -> Reading:
    """Readings beyond 0 .. 50 um at either side stop at the end of the range and say so."""
    under, over = (sums < 0.0).any(axis=1), (sums > 2.0 * RANGE_UM).any(axis=1)
    kept = np.clip(sums, 0.0, 2.0 * RANGE_UM)
    return Reading(kept[:, 0], kept[:, 1], np.where(over, OVER_RANGE, np.where(under, UNDER_RANGE, OK)))
