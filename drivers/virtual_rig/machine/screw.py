"""The screw as two concentric layers of 436 cells each; and along its axis, where it grows: held by the anchor bearing
alone, which does not give way, or by springs at both bearings."""

import math
from typing import NamedTuple, Self

import numpy as np

from drivers.virtual_rig.machine.flows import Screw
from drivers.virtual_rig.machine.geometry import (
    BORE_RADIUS_M,
    OUTER_RADIUS_M,
    SCREW_MM,
    SPAN_MM,
    TABLE_MM,
    nut_centre_mm,
)
from drivers.virtual_rig.population.constants import Screw as Steel

CELLS = 436
YOUNG_PA = 206e9
ANCHOR_N_UM, FREE_N_UM = 900.0, 700.0  # planted: the free bearing holds the screw, too
LAYER_RADIUS_M = 0.014  # where the bore layer ends and the outer layer begins

CELL_M = (SCREW_MM[1] - SCREW_MM[0]) * 1e-3 / CELLS
CELL_MM = SCREW_MM[0] + (np.arange(CELLS) + 0.5) * CELL_M * 1e3  # centres of the cells, mm
EDGES_MM = CELL_MM[0] + (np.arange(CELLS + 1) - 0.5) * CELL_M * 1e3


def ring_area(inner: float, outer: float) -> float:
    """A = pi (b^2 - a^2)   m2"""
    return math.pi * (outer**2 - inner**2)


AREA_M2 = ring_area(BORE_RADIUS_M, OUTER_RADIUS_M)
BORE_SHARE = ring_area(BORE_RADIUS_M, LAYER_RADIUS_M) / AREA_M2


def mean_above_bore(conductivity: float) -> float:
    """Mean minus bore temperature of an insulated hollow cylinder warming evenly, per W/m through its surface.

        [(b^2 - a^2)^2 / 8 - a^2 (b^2 ln(b/a) / 2 - (b^2 - a^2) / 4)] pi / (k A^2)      K m/W

    From the radial heat equation at a steady rate; 0.05 K at 118 W/m.
    """
    a, b = BORE_RADIUS_M, OUTER_RADIUS_M
    ring = b**2 - a**2
    bracket = ring**2 / 8.0 - a**2 * (b**2 * math.log(b / a) / 2.0 - ring / 4.0)
    return bracket * math.pi / (conductivity * AREA_M2**2)


def steel(made_of: Steel, conduction: float) -> Screw:
    """The screw's cells; the layers' conductance gives the exact bore deficit: g = f (1 - f) / deficit  W/(m K)."""
    along = conduction * made_of.conductivity * AREA_M2 / CELL_M
    capacity = made_of.volumetric_heat * AREA_M2 * CELL_M
    across = BORE_SHARE * (1.0 - BORE_SHARE) / mean_above_bore(made_of.conductivity) * CELL_M
    return Screw(
        along * BORE_SHARE, along * (1.0 - BORE_SHARE), across, capacity * BORE_SHARE, capacity * (1.0 - BORE_SHARE)
    )


def overlap(from_mm: float, to_mm: float) -> np.ndarray:
    """Share of each cell that lies inside [from, to]: (CELLS,)"""
    half = CELL_M * 1e3 / 2.0
    low = np.maximum(CELL_MM - half, from_mm)
    high = np.minimum(CELL_MM + half, to_mm)
    return np.clip(high - low, 0.0, None) / (2.0 * half)


def mean_temperature(bore: np.ndarray, outer: np.ndarray) -> np.ndarray:
    """Area-weighted mean of the two layers, degC: (CELLS,)"""
    return BORE_SHARE * bore + (1.0 - BORE_SHARE) * outer


def growth_weights(from_mm: float, to_mm: float, expansion: float) -> np.ndarray:
    """What each cell adds to the growth of [from, to], um/K: rho * integral of the mean rise = weights @ rise"""
    return expansion * overlap(from_mm, to_mm) * CELL_M * 1e6


class Growths(NamedTuple):
    """What each cell's rise moves, um/K: the discs away from the middle, `motor` and `free` (CELLS,), and the nut away
    from the anchor bearing's place, `table` (positions, CELLS)."""

    motor: np.ndarray
    free: np.ndarray
    table: np.ndarray

    @classmethod
    def of(cls, anchor_mm: float, free_mm: float, expansion: float, held: float) -> Self:
        """`held`: by how much the free bearing holds the screw, 1: as planted, 0: not at all."""
        nuts = nut_centre_mm(np.array(TABLE_MM))
        if not held:
            motor = growth_weights(anchor_mm, SPAN_MM[1], expansion)
            free, *table = (growth_weights(place, anchor_mm, expansion) for place in (SPAN_MM[0], *nuts))
            return cls(motor, free, np.array(table))
        moves = _moves({anchor_mm: ANCHOR_N_UM, free_mm: held * FREE_N_UM}) * expansion
        motor, free, *table = (_at(place) @ moves for place in (SPAN_MM[1], SPAN_MM[0], *nuts))
        return cls(motor, -free, -np.array(table))


def _moves(springs: dict[float, float]) -> np.ndarray:
    """Where the cells' edges go, um per unit of strain of each cell: (CELLS + 1, CELLS), K u = f.

    A bar of cells between its edges, E A / h each, and springs to the machine, N/um, at some places.
    """
    bar = YOUNG_PA * AREA_M2 / CELL_M * 1e-6
    stretch = np.diff(np.eye(CELLS + 1), axis=0)
    stiffness = bar * stretch.T @ stretch
    for place, spring in springs.items():
        stiffness += spring * np.outer(_at(place), _at(place))
    return np.linalg.solve(stiffness, bar * CELL_M * 1e6 * stretch.T)


def _at(place_mm: float) -> np.ndarray:
    """A place between two edges, (CELLS + 1,)."""
    return np.clip(1.0 - abs(EDGES_MM - place_mm) / (CELL_M * 1e3), 0.0, None)
