"""The screw along its axis: held by the anchor bearing alone, which does not give way, or by springs at both ends."""

from typing import NamedTuple, Self

import numpy as np

from drivers.virtual_rig.machine.geometry import SPAN_MM, TABLE_MM, nut_centre_mm
from drivers.virtual_rig.machine.screw import AREA_M2, CELL_M, CELL_MM, CELLS, growth_weights

YOUNG_PA = 206e9
ANCHOR_N_UM, FREE_N_UM = 900.0, 700.0  # planted: the free bearing holds the screw, too
EDGES_MM = CELL_MM[0] + (np.arange(CELLS + 1) - 0.5) * CELL_M * 1e3


class Growths(NamedTuple):
    """What each cell's rise moves, um/K: the discs away from the middle, `motor` and `free` (CELLS,), and the nut away
    from the anchor bearing's place, `table` (positions, CELLS)."""

    motor: np.ndarray
    free: np.ndarray
    table: np.ndarray

    @classmethod
    def of(cls, anchor_mm: float, free_mm: float, expansion: float, held: float) -> Self:
        """`held`: by how much the free bearing holds the screw, 1: as planted, 0: not at all."""
        nuts = [nut_centre_mm(at) for at in TABLE_MM]
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
