"""What a feed axis is built of: the screw, its nut, the supports of its bearings and the bed.

Positions x are in mm from channel 1 (free end) to the motor side; fields carry their unit in their name.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from estimator.record import Array


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
    def edges_mm(self) -> Array:
        """Cell borders, (cells + 1,) mm."""
        return np.linspace(self.from_mm, self.to_mm, self.cells + 1)

    @cached_property
    def x_mm(self) -> Array:
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

    def warmed(self, away_mm: Array, seconds: float) -> Array:
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

    def relative_speed(self, omega: Array) -> Array:
        """Speed in rad/s over the reference speed."""
        return omega / (self.reference_rpm * 2 * np.pi / 60)

    def overlap(self, from_mm: float | Array, to_mm: float | Array) -> Array:
        """Share of each cell inside [from, to] mm: (..., cells), 0 ... 1. Complex where a place is."""
        lo = np.maximum(np.asarray(from_mm)[..., None], self.edges_mm[:-1])
        hi = np.minimum(np.asarray(to_mm)[..., None], self.edges_mm[1:])
        return np.maximum(hi - lo, 0.0) / (self.length * 1e3)

    def at(self, x_mm: float) -> Array:
        """Weights (cells,) that interpolate linearly at x between cell centres."""
        place = float(np.clip((x_mm - self.x_mm[0]) / (self.length * 1e3), 0.0, self.cells - 1.0))
        left = min(int(place), self.cells - 2)
        weights = np.zeros(self.cells)
        weights[left : left + 2] = left + 1 - place, place - left
        return weights

    def growth(self, from_mm: float | Array, to_mm: float | Array) -> Array:
        """Weights (..., cells) um/K: growth of [from, to] = expansion * integral of the temperature rise."""
        return self.expansion * self.overlap(from_mm, to_mm) * self.length * 1e6


@dataclass(frozen=True)
class Nut:
    """The nut: its centre is at `centre_mm + direction * position`."""

    length_mm: float
    centre_mm: float
    direction: float = -1.0

    def centre(self, position_mm: Array) -> Array:
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
