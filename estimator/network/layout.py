"""Where the nodes of a network stand among its states: the screw's cells between a few knots, then bodies."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from estimator.inputs.balls import product
from estimator.network import mesh
from estimator.record import Array
from estimator.rig import Rig
from estimator.terms import SCREW, Link, Shift, Spot, Store, Term


@dataclass(frozen=True)
class Layout:
    """Where each node stands: N network nodes (cells, then bodies), n states (knots, then bodies)."""

    nodes: dict[str, slice]
    shapes: Array  # V, (N, n)
    knots_mm: Array
    inputs: tuple[str, ...]  # measured inputs that links end at
    shifts: tuple[Shift, ...] = ()  # of them; inputs and shifts together are the boundaries
    _spots: dict[float, Array] = field(default_factory=dict)
    _products: dict[tuple[str, str], Array] = field(default_factory=dict)
    _sums: dict[tuple[str, str], Array] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Number of states n."""
        return self.shapes.shape[1]

    @property
    def boundaries(self) -> int:
        """Number of inputs and shifts that heat flows from."""
        return len(self.inputs) + len(self.shifts)

    @property
    def bodies(self) -> tuple[str, ...]:
        """Nodes with one temperature."""
        return tuple(node for node in self.nodes if node != SCREW)

    def rows(self, node: str) -> Array:
        """What the states say of a node's cells, (cells, n), or of a body, (1, n)."""
        return self.shapes[self.nodes[node]]

    def squares(self, node: str, weights: Any, regimes: int, other: str = "") -> Array:
        """Sum over a node's cells k of weights[:, k] rows[k] rows[k]', (regimes, n, n).

        other  of the rows less those of this node, or, where that is the node itself, of each row less the next
        """
        key, alike = (node, other), np.shape(weights)[-1:] in ((), (1,))
        kept = self._sums if alike else self._products  # a table of all cells takes megabytes
        i, j, half = self._pairs
        if key not in kept:
            rows = self.rows(node)
            rows = rows[:-1] - rows[1:] if node == other else rows - (self.rows(other) if other else 0.0)
            kept[key] = (rows.T @ rows)[None, i, j] if alike else rows[:, i] * rows[:, j]
        products = kept[key]
        each = np.broadcast_to(weights, (regimes, len(products)))
        some = np.flatnonzero(each.any(axis=0))  # a seat's are few of the screw's
        within = slice(some[0], some[-1] + 1) if len(some) else slice(0)
        return np.asarray(product(each[:, within], products[within])[:, half])

    @cached_property
    def _pairs(self) -> tuple[Array, Array, Array]:
        """Rows and columns of the upper half of a symmetric (n, n), and where in it each element is, (n, n)."""
        i, j = np.triu_indices(self.size)
        half = np.empty((self.size, self.size), dtype=int)
        half[i, j] = half[j, i] = np.arange(len(i))
        return i, j, half

    def spot(self, spot: Spot, rig: Rig) -> Array:
        """What the states say of the screw's temperature at a spot, (n,)."""
        if spot.at_mm not in self._spots:
            self._spots[spot.at_mm] = self._spot(spot.at_mm, rig)
        mean, bend = self._spots[spot.at_mm]
        return np.asarray(spot.weight * (mean + spot.deep * bend))

    def _spot(self, at_mm: float, rig: Rig) -> Array:
        """Of the section's mean, and of how it bends along the axis within the reach of its wall, 1/mm2: (2, n)."""
        screw, knots = rig.the_screw(), self.knots_mm
        reach = np.sqrt(screw.bore_mm2) or screw.length * 1e3
        ends = np.clip(at_mm + np.array([-reach, reach]), screw.from_mm, screw.to_mm)
        rows = np.zeros((3, self.size))
        if self.size == len(self.shapes):
            cell = screw.length * 1e3
            slopes = [(screw.at(end + cell / 2) - screw.at(end - cell / 2)) / cell for end in ends]
            rows[:] = np.vstack([screw.at(at_mm), *slopes]) @ self.rows(SCREW)
        else:
            rows[:, : len(knots)] = np.vstack([mesh.shapes(knots, np.array([at_mm])), mesh.slopes(knots, ends)])
        return np.array([rows[0], (rows[2] - rows[1]) / (2 * reach)])

    def state(self, node: str) -> int:
        """Index of a body among the states."""
        return len(self.knots_mm) + self.bodies.index(node)


def layout(terms: Sequence[Term], rig: Rig, reduced: bool = True) -> Layout:
    """Find the nodes: whatever stores heat is a state, whatever else a link ends at is an input of the rig."""
    nodes: dict[str, slice] = {}
    start = 0
    for term in sorted((t for t in terms if isinstance(t, Store)), key=lambda t: t.node != SCREW):
        size = rig.screw.cells if term.node == SCREW and rig.screw else 1
        nodes[term.node] = slice(start, start + size)
        start += size
    ends = {end for t in terms if isinstance(t, Link) for end in (t.a, t.b)} - set(nodes)
    places = mesh.knots(rig) if SCREW in nodes else np.empty(0)
    shifts = tuple(t for t in terms if isinstance(t, Shift))
    return Layout(nodes, _shapes(places, nodes, start, rig, reduced), places, tuple(sorted(ends)), shifts)


def _shapes(places: Array, nodes: dict[str, slice], size: int, rig: Rig, reduced: bool) -> Array:
    if not reduced or SCREW not in nodes:
        return np.eye(size)
    assert rig.screw is not None
    cells, bodies = nodes[SCREW].stop, size - nodes[SCREW].stop
    full = np.zeros((size, len(places) + bodies))
    full[:cells, : len(places)] = mesh.shapes(places, rig.screw.x_mm)
    full[cells:, len(places) :] = np.eye(bodies)
    return full
