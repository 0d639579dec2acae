"""The filter's full state x = (z, zeros, error of the expansion coefficient, growth at the start) around z.

zeros      of readings whose zero is unknown: constant but for a slow random walk
expansion  by which share the screw expands more than the model says: constant, known within the rig's tolerance; it
           acts on the open-loop growth, so that the system stays linear
start      c z at the first sample, constant: kept as a state, so that the elongation c z - start knows how much of its
           uncertainty both share
"""

from __future__ import annotations

import numpy as np

from estimator.network.assemble import Readings
from estimator.network.discretise import Transition
from estimator.record import Array


class Augmented:
    """Sizes and matrices of the full state, for n model states and m channels.

    zeros  state of each channel's unknown zero, by the channel's index
    """

    def __init__(self, readings: Readings, expansion_tolerance: float) -> None:
        self.n = readings.rows.shape[1]
        self.growth = readings.growth
        self._zeros = np.flatnonzero(np.real(readings.zero_sd))
        self.zeros = {int(i): self.n + k for k, i in enumerate(self._zeros)}
        self.size = self.n + len(self._zeros) + 2
        self.dtype = np.result_type(readings.rows, readings.zero_sd, readings.growth)
        self._rows = np.zeros((len(readings.rows), self.size), self.dtype)
        self._rows[:, : self.n] = readings.rows
        self._rows[self._zeros, list(self.zeros.values())] = 1.0
        self.spans = readings.spans
        self._variance = np.append(readings.zero_sd[self._zeros], expansion_tolerance) ** 2
        self._walk = np.append(readings.zero_walk[self._zeros], 0.0) ** 2

    def channel_zeros(self, x: Array) -> Array:
        """The unknown zeros in a full state, (m,); 0 for channels whose zero is known."""
        zeros = np.zeros(len(self._rows), x.dtype)
        zeros[list(self.zeros)] = x[list(self.zeros.values())]
        return zeros

    def rows(self, grown_um: float) -> Array:
        """H (m, size) when the model alone has grown by `grown_um` since the start."""
        rows = self._rows.copy()
        rows[:, -2] = self.spans * grown_um
        return rows

    def elongation(self, grown_um: float) -> Array:
        """Weights (size,) of the elongation: growth now, and by another coefficient, minus growth at the start."""
        weights = np.zeros(self.size, self.dtype)
        weights[: self.n], weights[-2], weights[-1] = self.growth, grown_um, -1.0
        return weights

    def prior(self, mean: Array, cov: Array) -> tuple[Array, Array]:
        """Full mean (size,) and covariance (size, size) from those of z, before the first update."""
        x, P = np.zeros(self.size, self.dtype), np.zeros((self.size, self.size), self.dtype)
        x[: self.n], P[: self.n, : self.n] = mean, cov
        at = np.arange(self.n, self.size - 1)
        P[at, at] = self._variance
        return x, P

    def remember_growth(self, x: Array, P: Array) -> None:
        """Make the last state the growth at this instant: x_e = c z, with its covariances. Changes x and P."""
        copy = np.eye(self.size, dtype=self.dtype)
        copy[-1] = np.concatenate([self.growth, np.zeros(self.size - self.n)])
        x[:], P[:] = copy @ x, copy @ P @ copy.T

    def first(self, prior: tuple[Array, Array], reading: Array, R: Array, fuse: Array) -> tuple[Array, Array]:
        """Estimate (size,), (size, size) after the first sample: prior, then the readings (m,) to fuse. May be complex.

        K = P H' S^-1;   x + K (y - H x);   P - K S K'
        """
        x, P = self.prior(*prior)
        H = self.rows(0.0)[fuse]
        S = H @ P @ H.T + np.diag(R[fuse])
        K = np.linalg.solve(S, H @ P).T
        x, P = x + K @ (reading[fuse] - H @ x), P - K @ S @ K.T
        self.remember_growth(x, P)
        return x, P

    def transition(self, z: Transition, dt: float) -> Transition:
        """F (size, size), J (size, n), Q (size, size) of the full state."""
        F, Q = np.eye(self.size), np.zeros((self.size, self.size))
        J = np.zeros((self.size, self.n))
        F[: self.n, : self.n], Q[: self.n, : self.n], J[: self.n] = z.F, z.Q, z.J
        at = np.arange(self.n, self.size - 1)
        Q[at, at] = self._walk * dt
        return Transition(F, J, Q)
