"""The table's strokes to and fro: position, speed and acceleration at any instant, stroke centres, pace of a tick."""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from drivers.virtual_rig.machine.geometry import LEAD_MM, OMEGA_20

ACCELERATION = 2000.0  # mm/s2 at the stroke ends


@dataclass(frozen=True)
class Stroke:
    """One stroke between two table positions: a ramp up, a constant speed, a ramp down."""

    low_mm: float
    high_mm: float
    speed_mm_s: float

    @property
    def ramp_s(self) -> float:
        """t = v / a   s, at either end"""
        return self.speed_mm_s / ACCELERATION

    @property
    def duration_s(self) -> float:
        """T = L / v + v / a   s"""
        return (self.high_mm - self.low_mm) / self.speed_mm_s + self.ramp_s

    def along(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Distance from the stroke's start (mm), speed (mm/s) and acceleration (mm/s2) at t seconds into it."""
        length, left = self.high_mm - self.low_mm, self.duration_s - t
        up, down = t < self.ramp_s, left < self.ramp_s
        middle = self.speed_mm_s * (t - self.ramp_s / 2.0)
        ending = length - ACCELERATION * left**2 / 2.0
        distance = np.where(up, ACCELERATION * t**2 / 2.0, np.where(down, ending, middle))
        speed = np.where(up, ACCELERATION * t, np.where(down, ACCELERATION * left, self.speed_mm_s))
        return distance, speed, ACCELERATION * (up.astype(float) - down)


@dataclass(frozen=True)
class Drive:
    """Strokes without a pause from `start_s` on; `strokes` is infinite while nobody has stopped it."""

    stroke: Stroke
    start_s: float
    from_low: bool
    strokes: float = math.inf

    @property
    def stop_s(self) -> float:
        """When the table stands again, s"""
        return self.start_s + self.strokes * self.stroke.duration_s

    @property
    def ends_low(self) -> bool:
        """Does the table park at the stroke's low end?"""
        return self.from_low == (self.strokes % 2 == 0)

    def centres(self, after_s: float, until_s: float) -> np.ndarray:
        """Instants in (after, until] at which the table passes the middle of a stroke, s"""
        period = self.stroke.duration_s
        first = max(math.floor((after_s - self.start_s) / period + 0.5), 0)
        last = min(math.floor((until_s - self.start_s) / period + 0.5), self.strokes)
        return self.start_s + (np.arange(first, last) + 0.5) * period

    def stroke_ends_by(self, t: float) -> int:
        """Whole strokes after which the table stands, if the operator stops it at t."""
        return math.ceil(round((t - self.start_s) / self.stroke.duration_s, 9))


@dataclass(frozen=True)
class TableMotion:
    """Position (mm), velocity (mm/s), acceleration (mm/s2) and whether the table moves, each (n,)"""

    position_mm: np.ndarray
    velocity_mm_s: np.ndarray
    acceleration_mm_s2: np.ndarray
    moving: np.ndarray

    @property
    def omega(self) -> np.ndarray:
        """|omega| = 2 pi |v| / lead   rad/s"""
        return 2.0 * np.pi * np.abs(self.velocity_mm_s) / LEAD_MM

    @property
    def speed_rpm(self) -> np.ndarray:
        """60 v / lead   rpm, signed"""
        return 60.0 * self.velocity_mm_s / LEAD_MM

    @property
    def turn_angle(self) -> np.ndarray:
        """2 pi z / lead   rad"""
        return 2.0 * np.pi * self.position_mm / LEAD_MM


@dataclass(frozen=True)
class Travel:
    """All drives of a run; the table stands between them, and at its low end before the first."""

    stroke: Stroke
    drives: tuple[Drive, ...] = field(default=())

    def moves_between(self, from_s: float, to_s: float) -> bool:
        """Does the table move at some instant of [from, to)?"""
        return any(drive.start_s < to_s and drive.stop_s > from_s for drive in self.drives)

    def at(self, t: np.ndarray) -> TableMotion:
        """Where the table is and how it moves at the instants t (n,) in s"""
        rest = np.full(t.shape, self.stroke.low_mm)
        position, velocity, acceleration = rest, np.zeros(t.shape), np.zeros(t.shape)
        moving = np.zeros(t.shape, dtype=bool)
        for drive in self.drives:
            parked = self.stroke.low_mm if drive.ends_low else self.stroke.high_mm
            position = np.where(t >= drive.stop_s, parked, position)
            now = (t >= drive.start_s) & (t < drive.stop_s)
            z, v, a = _in_drive(drive, t[now])
            position[now], velocity[now], acceleration[now] = z, v, a
            moving |= now
        return TableMotion(position, velocity, acceleration, moving)


def _in_drive(drive: Drive, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    number, into = np.divmod(t - drive.start_s, drive.stroke.duration_s)
    distance, speed, acceleration = drive.stroke.along(into)
    sign = np.where((number % 2 == 0) == drive.from_low, 1.0, -1.0)
    origin = np.where(sign > 0, drive.stroke.low_mm, drive.stroke.high_mm)
    return origin + sign * distance, sign * speed, sign * acceleration


class Pace(NamedTuple):
    """How the table moves in a tick.

    omega         speeds of its steps, rad/s;   share: of the steps in motion
    since_stop_s  since it last moved, negative: it never has;   since_start_s: since it set off, 0 at rest
    fading_s      of the air after a stop, the machine's
    """

    omega: np.ndarray
    share: float
    since_stop_s: float
    since_start_s: float
    fading_s: float

    @property
    def rested(self) -> float:
        """Share of the tick at rest after a motion."""
        return (1.0 - self.share) * (self.since_stop_s >= 0.0)

    def power(self, exponent: float) -> float:
        """Mean of (omega / omega at 20 m/min)^exponent."""
        return float(((self.omega / OMEGA_20) ** exponent).mean())

    def fading(self, seconds: float) -> float:
        """At rest, 1 just after the stop."""
        return self.rested * math.exp(-max(self.since_stop_s, 0.0) / seconds)
