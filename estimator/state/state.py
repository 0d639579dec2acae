"""The filter's full state x = (temperatures, zeros, expansion, start), each part named once.

temperatures  (n,) degC  of knots and bodies, z in the equations of the network
zeros         (k,) K or um  of readings whose zero is unknown: constant but for a slow random walk
expansion     1  by which share the screw expands more than the model says: constant, known as a fit or the rig file
              says; it acts on the open-loop growth, so that the system stays linear
start         um  growth c z at the first sample, constant: kept as a state, so that the elongation c z - start knows
              how much of its uncertainty both share. Where the rig says its zero_C it is c zero_C, which the first
              sample tells nothing of; what all thermometers are off together is its uncertainty
"""

import numpy as np

from estimator.faults.fault import Judgement
from estimator.network.assemble import Readings
from estimator.network.discretise import Transition
from estimator.record import Array
from estimator.rig import Rig


class State:
    """Places and matrices of the full state, for n temperatures and m channels.

    temperatures, zeros, constants  slices of x (size,); constants are the zeros and the expansion
    expansion, start                places in it
    zero_of                         place of each channel's unknown zero, by the channel's index
    """

    def __init__(self, readings: Readings, rig: Rig, expansion_sd: float) -> None:
        self.n = readings.rows.shape[1]
        with_zero = np.flatnonzero(np.real(readings.zero_sd))
        self.expansion = self.n + len(with_zero)
        self.start, self.size = self.expansion + 1, self.expansion + 2
        self.temperatures, self.zeros = slice(0, self.n), slice(self.n, self.expansion)
        self.constants = slice(self.n, self.start)
        self.zero_of = {int(i): self.n + k for k, i in enumerate(with_zero)}
        self.growth, self.spans, self._rig = readings.growth, readings.spans, rig
        self.dtype = np.result_type(readings.rows, readings.zero_sd, readings.growth)
        self._rows = np.zeros((len(readings.rows), self.size), self.dtype)
        self._rows[:, self.temperatures] = readings.rows
        self._rows[with_zero, self.zeros] = np.eye(len(with_zero))
        self._variance = np.append(readings.zero_sd[with_zero], expansion_sd) ** 2
        self._walk = np.append(readings.zero_walk[with_zero], 0.0) ** 2

    def channel_zeros(self, x: Array) -> Array:
        """The unknown zeros in a full state, (m,); 0 for channels whose zero is known."""
        zeros = np.zeros(len(self._rows), x.dtype)
        zeros[list(self.zero_of)] = x[self.zeros]
        return zeros

    def rows(self, grown_um: Array | float) -> Array:
        """H (..., m, size) when the model alone has grown by `grown_um` since the start."""
        rows = np.tile(self._rows, (*np.shape(grown_um), 1, 1))
        rows[..., self.expansion] = self.spans * np.asarray(grown_um)[..., None]
        return rows

    def elongation(self, grown_um: Array | float) -> Array:
        """Weights (..., size) of the elongation: growth now, and by another coefficient, minus growth at the start."""
        weights = np.zeros((*np.shape(grown_um), self.size), self.dtype)
        weights[..., self.temperatures], weights[..., self.start] = self.growth, -1.0
        weights[..., self.expansion] = grown_um
        return weights

    def prior(self, mean: Array, cov: Array) -> tuple[Array, Array]:
        """Full mean (size,) and covariance (size, size) from those of z, before the first update."""
        x, P = np.zeros(self.size, self.dtype), np.zeros((self.size, self.size), self.dtype)
        x[self.temperatures], P[self.temperatures, self.temperatures] = mean, cov
        P[self.constants, self.constants] = np.diag(self._variance)
        return x, P

    def first(self, prior: tuple[Array, Array], reading: Array, R: Array, fuse: Array) -> tuple[Array, Array]:
        """Estimate (size,), (size, size) after the first sample: prior, then the readings (m,) to fuse. May be complex.

        K = P H' S^-1;   x + K (y - H x);   P - K S K';   then the start is c z of that estimate, or c zero_C
        """
        x, P = self.prior(*prior)
        H = self.rows(0.0)[fuse]
        S = H @ P @ H.T + np.diag(R[fuse])
        K = np.linalg.solve(S, H @ P).T
        x, P = x + K @ (reading[fuse] - H @ x), P - K @ S @ K.T
        zero_C, um_per_K = self._rig.zero_C, self.growth.sum()
        copy = np.eye(self.size, dtype=self.dtype)
        copy[self.start, self.start] = 0.0
        copy[self.start, self.temperatures] = self.growth if zero_C is None else 0.0
        x, P = copy @ x, copy @ P @ copy.T
        if zero_C is not None:
            x[self.start], P[self.start, self.start] = um_per_K * zero_C, (um_per_K * self._rig.zero_sd_K) ** 2
        return x, P

    def began_um(self, x: Array) -> float:
        """Growth at the first sample, after which the full state is x: 0 but for a rig with a zero_C."""
        if self._rig.zero_C is None:
            return 0.0
        return float(np.real(self.growth @ x[self.temperatures] - x[self.start]))

    def jumped(self, P: Array, jump: Array) -> Array:
        """P when the zeros of channels have become others, about as far off as their readings jumped, (m,)."""
        loose = P.copy()
        for i, place in self.zero_of.items():
            loose[place, place] += jump[i] ** 2
        return loose

    def astray(self, P: Array, drift: Array) -> Array:
        """How far estimates are astray, P (K, size, size), if what channels have drifted by, (K, m), is heat.

        P h / (h P h') drift, h without its zero: a column for each that has drifted at any tick, (K, size, q). Where
        the zero is known, that is as well how far the channel has led them astray if it is none.
        """
        which = np.flatnonzero(drift.any(axis=0))
        h = self._rows[which].T.copy()
        h[self.zeros] = 0.0
        return _led_by(P, h, drift[:, which])

    def misled(self, P: Array, drift: Array) -> Array:
        """P when channels that were fused turn out to have drifted by so much, (m,): P + v v', v how they led it."""
        which = np.flatnonzero(drift)
        v = _led_by(P[None], self._rows[which].T, drift[None, which])[0]
        return np.asarray(P + v @ v.T)

    def heated(self, x: Array, P: Array, which: Array) -> tuple[Array, Array]:
        """An estimate x, P when the zeros of some channels, (m,) bool, turn out to be what a run begins with."""
        places = [place for i, place in self.zero_of.items() if which[i]]
        known = np.diag(self._variance[[place - self.n for place in places]])
        K = np.linalg.solve(P[np.ix_(places, places)] + known, P[places]).T
        return x - K @ x[places], P - K @ P[places]

    def led(self, grown_um: Array, x: Array, unled: tuple[Array, Array]) -> tuple[Array, Array]:
        """How far lengths have led estimates x (K, size) from those without, x and P (K, size, size), um, and the
        variance of the latter, um^2."""
        weights = self.elongation(grown_um)
        weights[:, self.start] = 0.0
        um = (weights * (x - unled[0])).sum(axis=1)
        return um, np.vecdot((weights[:, None] @ unled[1])[:, 0], weights)

    def judged(self, x: Array, P: Array, judgement: Judgement) -> tuple[Array, Array]:
        """x and P after what a tick's judgement says of readings that were fused before, or will be."""
        P = P if judgement.jump is None else self.jumped(P, judgement.jump)
        P = P if judgement.loose is None else self.jumped(P, judgement.loose)
        P = P if judgement.drift is None else self.misled(P, judgement.drift)
        return (x, P) if judgement.heated is None else self.heated(x, P, judgement.heated)

    def transition(self, z: Transition, dt: float) -> Transition:
        """F (size, size), J (size, n), Q (size, size) of the full state."""
        F, Q = np.eye(self.size), np.zeros((self.size, self.size))
        J = np.zeros((self.size, self.n))
        at, constants = self.temperatures, self.constants
        F[at, at], Q[at, at], J[at] = z.F, z.Q, z.J
        Q[constants, constants] = np.diag(self._walk * dt)
        return Transition(F, J, Q)


def _led_by(P: Array, h: Array, by: Array) -> Array:
    """By how much estimates change, (K, size, q), if channels with rows h', h (size, q), read so much more, (K, q)."""
    Ph = P @ h
    return np.asarray(Ph * (by / (h * Ph).sum(axis=1))[:, None])
