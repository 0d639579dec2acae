"""The rig: geometry, material, channels and inputs; `rig_file.py` reads it from a rig folder.

Positions x are in mm from channel 1 (free end) to the motor side; fields carry their unit in their name.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from estimator.errors import SetupError, nearest
from estimator.rig_log import Log

Vector = NDArray[Any]
RAD_S = {"rpm": 2 * np.pi / 60, "rad/s": 1.0}  # units that a speed may have
NOT_GEOMETRY = {"expansion_tolerance", "cells", "knots_mm"}
Part = TypeVar("Part")


@dataclass(frozen=True)
class Signal:
    """One measured value: where it comes from and what it may physically be.

    value = scale * (sum of the CAN signals, or the CSV column) + offset, in `unit`; outside lo..hi it counts as
    not measured. `fresh` names a CAN signal or CSV column that changes with each new reading (else each is one);
    `valid` is a condition such as "Message.Signal = 0".
    """

    signal: str | tuple[str, ...] = ()
    column: str | None = None
    unit: str = "degC"
    scale: float = 1.0
    offset: float = 0.0
    lo: float = -60.0
    hi: float = 200.0
    fresh: str | None = None
    valid: str | None = None

    @property
    def signals(self) -> tuple[str, ...]:
        """The CAN signals as "Message.Signal"."""
        return (self.signal,) if isinstance(self.signal, str) else tuple(self.signal)


@dataclass(frozen=True)
class Channel(Signal):
    """A signal that the filter compares with its model: a thermometer on the screw or in a body, or a length."""

    at_mm: float | None = None
    node: str | None = None

    @property
    def is_thermometer(self) -> bool:
        """Whether the channel reads a temperature (else: the displacement, in um)."""
        return self.at_mm is not None or self.node is not None


@dataclass(frozen=True)
class Screw:
    """The body along x: a hollow bar of `cells` equal cells between `from_mm` and `to_mm`."""

    from_mm: float
    to_mm: float
    outer_mm: float
    bore_mm: float = 0.0
    lead_mm: float = 12.0
    density: float = 7850.0  # kg/m3
    heat_capacity: float = 470.0  # J/(kg K)
    conductivity: float = 46.0  # W/(m K)
    expansion: float = 12e-6  # 1/K
    expansion_tolerance: float = 0.01  # standard deviation of the coefficient, as a share of it
    span_from_mm: float | None = None
    span_to_mm: float | None = None
    reference_rpm: float = 1667.0  # speed at which friction powers are given
    cells: int = 270
    knots_mm: tuple[float, ...] = ()

    @cached_property
    def edges_mm(self) -> Vector:
        """Cell borders, (cells + 1,) mm."""
        return np.linspace(self.from_mm, self.to_mm, self.cells + 1)

    @cached_property
    def x_mm(self) -> Vector:
        """Cell centres, (cells,) mm."""
        return (self.edges_mm[1:] + self.edges_mm[:-1]) / 2

    @cached_property
    def length(self) -> float:
        """Length of one cell, m."""
        return (self.to_mm - self.from_mm) * 1e-3 / self.cells

    @property
    def area(self) -> float:
        """Cross-section, m2."""
        return float(np.pi / 4 * (self.outer_mm**2 - self.bore_mm**2) * 1e-6)

    def warmed(self, away_mm: Vector, seconds: float) -> Vector:
        """By how much 1 W into one place warms the bar so far away after so long, K, before anything of it is lost.

            T = sqrt(t / a) / (rho c A) ierfc(|x| / (2 sqrt(a t))),    ierfc(u) = exp(-u^2) / sqrt(pi) - u erfc(u)

        a the diffusivity (Carslaw and Jaeger 1959, 2.9, half of it to either side).
        """
        from scipy.special import erfc  # imported late: few rigs are ever asked

        stores = self.density * self.heat_capacity
        diffusivity = self.conductivity / stores
        u = np.abs(away_mm) * 1e-3 / (2.0 * np.sqrt(diffusivity * seconds))
        integral = np.exp(-(u**2)) / np.sqrt(np.pi) - u * erfc(u)
        return np.asarray(np.sqrt(seconds / diffusivity) / (stores * self.area) * integral)

    @cached_property
    def bore_mm2(self) -> float:
        """How much more than the mean of its section the wall of the bore follows what is beside it: T + bore d2T/dx2.

        Heat that enters outside, a and b the radii, leaves the wall below the mean of the section by the mean of

            (r^2 - a^2) / 4 - a^2 ln(r / a) / 2     m2, times the rate at which the section warms over its diffusivity

        and the heat that it does not store flows along the axis, k A d2T/dx2. What it stores is a lag, 2 s. A bar
        without a bore has its thermometers anywhere: 0.
        """
        a2, b2 = (self.bore_mm / 2) ** 2, (self.outer_mm / 2) ** 2
        if not a2:
            return 0.0
        ring = b2 - a2
        return float(ring / 8 - a2 * (b2 * np.log(b2 / a2) / ring - 1) / 4)

    @property
    def surface(self) -> float:
        """Outer surface of one cell, m2."""
        return float(np.pi * self.outer_mm * 1e-3 * self.length)

    @property
    def span_mm(self) -> tuple[float, float]:
        """The measured span whose growth is the elongation, mm."""
        lo = self.from_mm if self.span_from_mm is None else self.span_from_mm
        return lo, self.to_mm if self.span_to_mm is None else self.span_to_mm

    def relative_speed(self, omega: Vector) -> Vector:
        """Speed in rad/s over the reference speed."""
        return omega / (self.reference_rpm * 2 * np.pi / 60)

    def overlap(self, from_mm: float | Vector, to_mm: float | Vector) -> Vector:
        """Share of each cell inside [from, to] mm: (..., cells), 0 ... 1. Complex where a place is."""
        lo = np.maximum(np.asarray(from_mm)[..., None], self.edges_mm[:-1])
        hi = np.minimum(np.asarray(to_mm)[..., None], self.edges_mm[1:])
        return np.maximum(hi - lo, 0.0) / (self.length * 1e3)

    def at(self, x_mm: float) -> Vector:
        """Weights (cells,) that interpolate linearly at x between cell centres."""
        place = float(np.clip((x_mm - self.x_mm[0]) / (self.length * 1e3), 0.0, self.cells - 1.0))
        left = min(int(place), self.cells - 2)
        weights = np.zeros(self.cells)
        weights[left : left + 2] = left + 1 - place, place - left
        return weights

    def growth(self, from_mm: float | Vector, to_mm: float | Vector) -> Vector:
        """Weights (..., cells) um/K: growth of [from, to] = expansion * integral of the temperature rise."""
        return self.expansion * self.overlap(from_mm, to_mm) * self.length * 1e6


@dataclass(frozen=True)
class Nut:
    """The nut: its centre is at `centre_mm + direction * position`."""

    length_mm: float
    centre_mm: float
    direction: float = -1.0

    def centre(self, position_mm: Vector) -> Vector:
        """Centre of the nut in screw coordinates, mm, for table positions in mm."""
        return self.centre_mm + self.direction * position_mm


@dataclass(frozen=True)
class Support:
    """A bearing: where it holds the screw."""

    at_mm: float
    width_mm: float


@dataclass(frozen=True)
class Bed:
    """What the table's place is told by, and grows too: the machine's bed, or a scale of the table's own.

    input      the thermometer that shows its temperature
    tolerance  standard deviation of the coefficient, as a share of it
    """

    input: str
    expansion: float = 11e-6  # 1/K
    tolerance: float = 0.05


@dataclass(frozen=True)
class Rig:
    """A whole installation. `channels` keeps the order of the file; the displacement is a channel like the others.

    zero_C     temperature of the whole screw at which its growth is zero; None: growth counts from the first sample
    zero_sd_K  how well all thermometers together are known against it
    """

    name: str
    tick_s: float
    channels: Mapping[str, Channel]
    inputs: Mapping[str, Signal]
    screw: Screw | None = None
    nut: Nut | None = None
    bed: Bed | None = None
    supports: Mapping[str, Support] = field(default_factory=dict)
    log: Log = field(default_factory=Log)
    subset_7: tuple[str, ...] = ()
    zero_C: float | None = None
    zero_sd_K: float = 0.0
    folder: Path = Path()

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Channel names in order, (m,)."""
        return tuple(self.channels)

    @property
    def expansion_tolerance(self) -> float:
        """How well the expansion coefficient is known, as a share of it; 0 without a screw."""
        return self.screw.expansion_tolerance if self.screw else 0.0

    @cached_property
    def thermometers(self) -> tuple[str, ...]:
        """Names of the channels that read a temperature, in order."""
        return tuple(name for name, channel in self.channels.items() if channel.is_thermometer)

    @cached_property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies that thermometers read."""
        return tuple(sorted({channel.node for channel in self.channels.values() if channel.node is not None}))

    @cached_property
    def is_thermometer(self) -> Vector:
        """Which channels read a temperature, (m,) bool."""
        return np.array([channel.is_thermometer for channel in self.channels.values()], dtype=bool)

    @cached_property
    def seats(self) -> Vector:
        """Share of each cell inside a bearing, (cells,); nothing without a screw."""
        screw = self.screw
        if screw is None:
            return np.zeros(0)
        ends = [(each.at_mm - each.width_mm / 2, each.at_mm + each.width_mm / 2) for each in self.supports.values()]
        return np.clip(sum((screw.overlap(*each) for each in ends), np.zeros(screw.cells)), 0.0, 1.0)

    @property
    def lengths(self) -> tuple[str, ...]:
        """Names of the channels that read a length, in order."""
        return tuple(name for name, channel in self.channels.items() if not channel.is_thermometer)

    @property
    def moves(self) -> bool:
        """Whether anything is told of a motion."""
        return bool({"speed", "position"} & {*self.inputs})

    @cached_property
    def stroke_mm(self) -> tuple[float, float] | None:
        """Table positions at which the nut is between the bearings; None where a table has no error by growth."""
        screw, nut, anchor = self.screw, self.nut, self.supports.get("anchor")
        if screw is None or nut is None or anchor is None or "position" not in self.inputs:
            return None
        others = [each.at_mm for each in self.supports.values() if each is not anchor] or [screw.from_mm, screw.to_mm]
        low, high = sorted((anchor.at_mm, max(others, key=lambda at_mm: abs(at_mm - anchor.at_mm))))
        centres = low + nut.length_mm / 2, high - nut.length_mm / 2
        lowest, highest = sorted((centre - nut.centre_mm) / nut.direction for centre in centres)
        return lowest, highest

    def index(self, name: str) -> int:
        """Column of a channel; an unknown name is a SetupError."""
        if name not in self.channels:
            raise SetupError(f"{self.folder / 'rig.toml'}: no channel '{name}'; {nearest(name, self.channels)}")
        return self.names.index(name)

    def the_screw(self) -> Screw:
        """The body along x, for an effect that needs one; without it a SetupError."""
        return self._the("screw", self.screw)

    def the_nut(self) -> Nut:
        """The nut, likewise."""
        return self._the("nut", self.nut)

    def the_support(self, name: str) -> Support:
        """A bearing by name, likewise."""
        return self._the(f"supports.{name}", self.supports.get(name))

    def _the(self, key: str, part: Part | None) -> Part:
        if part is None:
            raise SetupError(f"needs [{key}], which {self.name} has not; add it to rig.toml or leave the effect out")
        return part

    def fingerprint(self) -> str:
        """Short hash of geometry and material, kept in fitted models; not of the mesh or of how well they are known."""
        screw = self.screw and {k: v for k, v in asdict(self.screw).items() if k not in NOT_GEOMETRY}
        return hashlib.sha256(repr((screw, self.nut, sorted(self.supports.items()))).encode()).hexdigest()[:12]
