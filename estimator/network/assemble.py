"""Terms into a linear parameter-varying system, on the reduced mesh:

    M dz/dt = -G z + B T_in + V'q,      y = H z + d

with T = V z the temperatures of all nodes, M = V'C V, G = V'(network)V. G, B, H and the noise belong to a regime (a
speed, a place of the nut, a warmth at rest that hold for a while); q and d belong to a tick.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from estimator.inputs.balls import ByBalls, product
from estimator.inputs.inputs import Inputs
from estimator.network.growth import Growth
from estimator.network.layout import Layout
from estimator.record import Array
from estimator.rig import Rig
from estimator.terms import ELONGATION, SCREW, Chain, Heat, Lag, Link, Read, Shift, Spot, Store, Term

Projection = Callable[[Any, Any, Array], Array]
REAL = {float, int, str, bool, np.float64}  # most of what terms say: to look at a type costs least


@dataclass(frozen=True)
class Network:
    """The system of R regimes: mass (n, n), conductance (R, n, n), inflow (R, n, boundaries), noise (R, n, n)."""

    mass: Array
    conductance: Array
    inflow: Array
    noise: Array

    @classmethod
    def none(cls, place: Layout, regimes: int, dtype: Any = float) -> "Network":
        """Of nothing that stores, conducts or scatters."""
        n = place.size
        inflow = np.zeros((regimes, n, place.boundaries), dtype)
        return cls(np.zeros((n, n), dtype), np.zeros((regimes, n, n), dtype), inflow, np.zeros((regimes, n, n), dtype))


@dataclass(frozen=True)
class Readings:
    """What the channels read: rows (m, n) of H, scatter sd (m,), lag tau (m,) s with its noise, unknown zeros; how far
    each one's own lag and gain may be off.

    spans   (m,) how much of the elongation a channel reads: 1 for the displacement, 0 for thermometers
    growth  (n,) um/K of the measured span
    """

    rows: Array
    sd: Array
    tau: Array
    lag_noise: Array
    lag_sd: Array
    zero_sd: Array
    zero_walk: Array
    gain_sd: Array
    spans: Array
    growth: Array


def network_of(terms: Sequence[Term], place: Layout, regimes: int) -> Network:
    """What terms of R regimes add to the network: it is the sum over all terms. Complex where a term is.

    A link between two nodes whose temperatures are a'z and b'z is the matrix g (a - b)(a - b)'.
    """
    network = Network.none(place, regimes, _dtype(terms))
    mass, conductance, inflow, noise = network.mass, network.conductance, network.inflow, network.noise
    for term in terms:
        if isinstance(term, Store):
            mass += place.squares(term.node, term.capacity, 1)[0]
            noise += place.squares(term.node, np.asarray(term.noise) ** 2, regimes)
        elif isinstance(term, Chain):
            conductance += place.squares(term.node, term.g, regimes, term.node)
        elif isinstance(term, Link):
            _link(conductance, inflow, place, term)
        elif isinstance(term, Heat) and term.node in place.nodes:
            scatter = np.broadcast_to(spread(term.noise, term.over, place.rows(term.node)), (regimes, place.size))
            noise += scatter[:, :, None] * scatter[:, None, :]
    return network


def _dtype(terms: Sequence[Term]) -> Any:
    """complex where a term's value is, else float."""
    return complex if any(map(is_complex, terms)) else float


def is_complex(term: Term, but: str = "") -> bool:
    """Whether anything that a term says is complex, one field left out."""
    return any(type(value) not in REAL and key != but and is_complex_value(value) for key, value in vars(term).items())


def is_complex_value(value: object) -> bool:
    """Whether a number, an array, a cover by the balls or one weight of a Read, or of several, is complex."""
    if isinstance(value, np.ndarray):
        return value.dtype.kind == "c"
    if isinstance(value, Mapping | Spot):
        parts = (value.weight, value.deep) if isinstance(value, Spot) else value.values()
        return any(map(is_complex_value, parts))
    return isinstance(value, complex) or (isinstance(value, ByBalls) and value.is_complex)


def _link(conductance: Array, inflow: Array, place: Layout, term: Link) -> None:
    a, b = (term.a, term.b) if term.a in place.nodes else (term.b, term.a)
    regimes, rows = len(conductance), place.rows(a)
    if b in place.nodes:
        conductance += place.squares(a, np.multiply(term.g, term.over), regimes, b)
    else:
        g = np.broadcast_to(np.multiply(term.g, term.over), (regimes, len(rows)))
        conductance += place.squares(a, g, regimes)
        inflow[:, :, place.inputs.index(b)] += product(g, rows)
        for k, shift in enumerate(place.shifts, start=len(place.inputs)):
            if shift.input == b and np.size(shift.over) in (1, len(rows)):
                inflow[:, :, k] += product(g * shift.over, rows)


def spread(q: Any, over: Any, rows: Array) -> Array:
    """q over, (ticks, cells), projected on the states: (ticks, n); (1, n) for a q without ticks."""
    q = np.atleast_2d(q)
    if isinstance(over, ByBalls):
        return over.carried(q, rows)
    if q.shape[1] == 1:
        return q * (over @ rows if np.shape(over)[-1:] == rows.shape[:1] else np.multiply(over, rows.sum(axis=0)))
    return product(q * over, rows)


def heat(terms: Sequence[Term], place: Layout, ticks: int, projected: Projection = spread) -> Array:
    """V'q: heat put in, projected on the states, (ticks, n) W."""
    total = np.zeros((ticks, place.size), _dtype([term for term in terms if isinstance(term, Heat)]))
    for term in terms:
        if isinstance(term, Heat) and term.node in place.nodes:
            total += projected(term.q, term.over, place.rows(term.node))
    return total


def outside(terms: Sequence[Term], u: Inputs, place: Layout) -> Array:
    """What the boundaries are at, (ticks, boundaries): inputs, then by how much they are shifted."""
    shifts = [np.broadcast_to(term.by, (len(u), 1)) for term in terms if isinstance(term, Shift)]
    return np.hstack([np.empty((len(u), 0)), *(u[name] for name in place.inputs), *shifts])


def span_growth(terms: Sequence[Term], rig: Rig, place: Layout) -> Array:
    """Weights (n,) um/K: growth of the measured span; zeros without a screw."""
    if rig.screw is None or SCREW not in place.nodes:
        return np.zeros(place.size)
    return np.asarray(Growth(terms, rig).span() @ place.rows(SCREW))


def offsets(terms: Sequence[Term], rig: Rig, ticks: int) -> Array:
    """d: what the channels read beside the temperatures, (ticks, m)."""
    reads = [term for term in terms if isinstance(term, Read)]
    dtype = complex if any(is_complex_value(each.offset) for each in reads) else float
    total = np.zeros((ticks, len(rig.names)), dtype)
    for term in reads:
        i = rig.index(term.channel)
        total[:, i : i + 1] += term.offset
    return total


def readings(terms: Sequence[Term], rig: Rig, place: Layout) -> Readings:
    """H, scatter, lags and zeros of the channels; one that no effect reads has a row of zeros and sd inf."""
    m, dtype = len(rig.names), _dtype(terms)
    rows, known = np.zeros((m, place.size), dtype), np.zeros(m, dtype=bool)
    variance, tau, lag_noise, lag_sd, zero_sd, zero_walk, gain_sd, spans = np.zeros((8, m), dtype)
    for term in terms:
        if isinstance(term, Read):
            i = rig.index(term.channel)
            rows[i] += sum((_row(node, weight, terms, rig, place) for node, weight in term.weights.items()), 0.0)
            spans[i] += term.weights.get(ELONGATION, 0.0)
            variance[i] += term.sd**2
            known[i] = True
            zero_sd[i] = np.sqrt(zero_sd[i] ** 2 + term.zero_sd**2)
            zero_walk[i] = np.sqrt(zero_walk[i] ** 2 + term.zero_walk**2)
            gain_sd[i] = np.sqrt(gain_sd[i] ** 2 + term.gain_sd**2)
        elif isinstance(term, Lag):
            i = rig.index(term.channel)
            tau[i] += term.tau
            lag_noise[i] = np.sqrt(lag_noise[i] ** 2 + term.noise**2)
            lag_sd[i] = np.sqrt(lag_sd[i] ** 2 + term.own_sd**2)
    sd = np.where(known, np.sqrt(variance), np.inf)
    growth = span_growth(terms, rig, place)
    return Readings(rows, sd, tau, lag_noise, lag_sd, zero_sd, zero_walk, gain_sd, spans, growth)


def _row(node: str, weight: Any, terms: Sequence[Term], rig: Rig, place: Layout) -> Array:
    """What one weight of a Read adds to its row, (n,)."""
    if node == ELONGATION:
        rig.the_screw()
        return weight * span_growth(terms, rig, place)
    if isinstance(weight, Spot):
        return place.spot(weight, rig)
    return np.atleast_1d(weight) @ place.rows(node)
