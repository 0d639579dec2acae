"""Terms into a linear parameter-varying system, on the reduced mesh:

    M dz/dt = -G z + B T_in + V'q,      y = H z + d

with T = V z the temperatures of all nodes, M = V'C V, G = V'(network)V. G, B, H and the noise belong to a regime (a
speed and a place of the nut that hold for a while); q and d belong to a tick.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimator import basis
from estimator.errors import SetupError
from estimator.inputs import Inputs
from estimator.model import Model
from estimator.record import Array
from estimator.rig import Rig
from estimator.terms import ELONGATION, SCREW, Chain, Expand, Heat, Lag, Link, Read, Store, Term


@dataclass(frozen=True)
class Layout:
    """Where each node stands: N network nodes (cells, then bodies), n states (knots, then bodies)."""

    nodes: dict[str, slice]
    shapes: Array  # V, (N, n)
    knots_mm: Array
    boundaries: tuple[str, ...]  # measured inputs that links end at

    @property
    def size(self) -> int:
        """Number of states n."""
        return self.shapes.shape[1]

    @property
    def bodies(self) -> tuple[str, ...]:
        """Nodes with one temperature."""
        return tuple(node for node in self.nodes if node != SCREW)

    def state(self, node: str) -> int:
        """Index of a body among the states."""
        return len(self.knots_mm) + self.bodies.index(node)


@dataclass(frozen=True)
class Network:
    """The system of R regimes: mass (n, n), conductance (R, n, n), inflow (R, n, boundaries), noise (R, n, n)."""

    mass: Array
    conductance: Array
    inflow: Array
    noise: Array


@dataclass(frozen=True)
class Readings:
    """What the channels read: rows (m, n) of H, scatter sd (m,), lag tau (m,) s with its noise, the unknown zeros.

    spans  (m,) how much of the elongation a channel reads: 1 for the displacement, 0 for thermometers
    """

    rows: Array
    sd: Array
    tau: Array
    lag_noise: Array
    zero_sd: Array
    zero_walk: Array
    spans: Array


def layout(terms: Sequence[Term], rig: Rig, reduced: bool = True) -> Layout:
    """Find the nodes: whatever stores heat is a state, whatever else a link ends at is an input of the rig."""
    nodes: dict[str, slice] = {}
    start = 0
    for term in sorted((t for t in terms if isinstance(t, Store)), key=lambda t: t.node != SCREW):
        if term.node in nodes:
            raise SetupError(f"node '{term.node}' is stored twice; one effect declares a node's Store")
        size = rig.screw.cells if term.node == SCREW and rig.screw else 1
        nodes[term.node] = slice(start, start + size)
        start += size
    ends = {end for t in terms if isinstance(t, Link) for end in (t.a, t.b)} - set(nodes)
    places = basis.knots(rig) if SCREW in nodes else np.empty(0)
    return Layout(nodes, _shapes(places, nodes, start, rig, reduced), places, tuple(sorted(ends)))


def _shapes(places: Array, nodes: dict[str, slice], size: int, rig: Rig, reduced: bool) -> Array:
    if not reduced or SCREW not in nodes:
        return np.eye(size)
    assert rig.screw is not None
    cells, bodies = nodes[SCREW].stop, size - nodes[SCREW].stop
    full = np.zeros((size, len(places) + bodies))
    full[:cells, : len(places)] = basis.shapes(places, rig.screw.x_mm)
    full[cells:, len(places) :] = np.eye(bodies)
    return full


def network(model: Model, rig: Rig, place: Layout, u: Inputs) -> Network:
    """Assemble mass, conductance, inflow and noise for the R regimes whose inputs are the rows of `u`."""
    terms = list(model.terms(u, rig))
    regimes, size = len(u), len(place.shapes)
    dtype = np.result_type(*(np.asarray(v).dtype for t in terms for v in vars(t).values() if _numeric(v)), float)
    mass = np.zeros((1, size), dtype)
    g = np.zeros((regimes, size, size), dtype)
    inflow = np.zeros((regimes, size, len(place.boundaries)), dtype)
    noise = np.zeros((regimes, size, size), dtype)
    for term in terms:
        if isinstance(term, Store):
            mass[:, place.nodes[term.node]] = term.capacity
            at = np.arange(size)[place.nodes[term.node]]
            noise[:, at, at] += np.asarray(term.noise) ** 2
        elif isinstance(term, Chain):
            cells = np.arange(size)[place.nodes[term.node]]
            _couple(g, cells[:-1], cells[1:], term.g)
        elif isinstance(term, Link):
            _link(g, inflow, place, term)
        elif isinstance(term, Heat) and term.node in place.nodes:
            rank_one = np.zeros((regimes, size), dtype)
            rank_one[:, place.nodes[term.node]] = term.noise
            noise += rank_one[:, :, None] * rank_one[:, None, :]
    v = place.shapes
    return Network((v.T * mass) @ v, v.T @ g @ v, v.T @ inflow, v.T @ noise @ v)


def _numeric(value: object) -> bool:
    return isinstance(value, (float, complex, np.ndarray, np.generic))


def _couple(g: Array, a: Array, b: Array, value: Array) -> None:
    """Add links of conductance `value` between the nodes a[i] and b[i]."""
    for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
        np.add.at(g, (slice(None), i, j), sign * np.broadcast_to(value, (len(g), len(a))))  # type: ignore[arg-type]


def _link(g: Array, inflow: Array, place: Layout, term: Link) -> None:
    a, b = (term.a, term.b) if term.a in place.nodes else (term.b, term.a)
    ends = np.arange(g.shape[1])[place.nodes[a]]
    value = np.broadcast_to(term.g, (len(g), max(len(ends), _width(b, place))))
    if b in place.nodes:
        others = np.arange(g.shape[1])[place.nodes[b]]
        width = value.shape[1]
        _couple(g, np.broadcast_to(ends, width), np.broadcast_to(others, width), value)
    else:
        g[:, ends, ends] += value
        inflow[:, ends, place.boundaries.index(b)] += value


def _width(node: str, place: Layout) -> int:
    return place.nodes[node].stop - place.nodes[node].start if node in place.nodes else 1


def heat(terms: Sequence[Term], place: Layout, ticks: int) -> Array:
    """V'q: heat put in, projected on the states, (ticks, n) W."""
    total = np.zeros((ticks, place.size))
    for term in terms:
        if isinstance(term, Heat) and term.node in place.nodes:
            q = np.broadcast_to(term.q, (ticks, _width(term.node, place)))
            total = total + q @ place.shapes[place.nodes[term.node]]
    return total


def growth(terms: Sequence[Term], rig: Rig, place: Layout, from_mm: float, to_mm: float) -> Array:
    """Weights (n,) um/K: growth of the screw between two places; zeros without a screw."""
    if rig.screw is None or SCREW not in place.nodes:
        return np.zeros(place.size)
    share = 1.0 + sum(term.error for term in terms if isinstance(term, Expand))
    return np.asarray(share * rig.screw.growth(from_mm, to_mm) @ place.shapes[place.nodes[SCREW]])


def offsets(terms: Sequence[Term], rig: Rig, ticks: int) -> Array:
    """d: what the channels read beside the temperatures, (ticks, m)."""
    total = np.zeros((ticks, len(rig.names)))
    for term in terms:
        if isinstance(term, Read):
            total[:, rig.index(term.channel)] += np.broadcast_to(term.offset, (ticks, 1))[:, 0]
    return total


def readings(terms: Sequence[Term], rig: Rig, place: Layout) -> Readings:
    """H, scatter, lags and zeros of the channels; one that no effect reads has a row of zeros and sd inf."""
    m = len(rig.names)
    rows, variance, known = np.zeros((m, place.size)), np.zeros(m), np.zeros(m, dtype=bool)
    tau, lag_noise, zero_sd, zero_walk, spans = np.zeros((5, m))
    for term in terms:
        if isinstance(term, Read):
            i = rig.index(term.channel)
            rows[i] += sum((_row(node, weight, terms, rig, place) for node, weight in term.weights.items()), 0.0)
            spans[i] += term.weights.get(ELONGATION, 0.0)
            variance[i] += term.sd**2
            known[i] = True
            zero_sd[i], zero_walk[i] = np.hypot(zero_sd[i], term.zero_sd), np.hypot(zero_walk[i], term.zero_walk)
        elif isinstance(term, Lag):
            i = rig.index(term.channel)
            tau[i], lag_noise[i] = tau[i] + term.tau, np.hypot(lag_noise[i], term.noise)
    return Readings(rows, np.where(known, np.sqrt(variance), np.inf), tau, lag_noise, zero_sd, zero_walk, spans)


def _row(node: str, weight: Array | float, terms: Sequence[Term], rig: Rig, place: Layout) -> Array:
    """What one weight of a Read adds to its row, (n,)."""
    if node == ELONGATION:
        return weight * growth(terms, rig, place, *rig.the_screw().span_mm)
    return np.atleast_1d(weight) @ place.shapes[place.nodes[node]]
