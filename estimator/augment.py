"""The filter's full state x = (z, zeros, growth at the start) around the model's states z.

zeros  of readings whose zero is unknown: constant but for a slow random walk
start  c z at the first sample, constant: kept as a state, so that the elongation c z - start knows how much of its
       uncertainty both share
"""

from __future__ import annotations

import numpy as np

from estimator.assemble import Readings
from estimator.discretise import Transition
from estimator.record import Array


class Augmented:
    """Sizes and matrices of the full state, for n model states and m channels."""

    def __init__(self, readings: Readings, growth: Array) -> None:
        self.n = readings.rows.shape[1]
        self.growth = growth
        self.zeros = np.flatnonzero(readings.zero_sd > 0)
        self.size = self.n + len(self.zeros) + 1
        at = self.n + np.arange(len(self.zeros))
        self.rows = np.zeros((len(readings.rows), self.size))
        self.rows[:, : self.n] = readings.rows
        self.rows[self.zeros, at] = 1.0
        self.elongation = np.concatenate([growth, np.zeros(len(self.zeros)), [-1.0]])
        self._zero_var = readings.zero_sd[self.zeros] ** 2
        self._walk_var = readings.zero_walk[self.zeros] ** 2

    def prior(self, mean: Array, cov: Array) -> tuple[Array, Array]:
        """Full mean (size,) and covariance (size, size) from those of z, before the first update."""
        x, P = np.zeros(self.size), np.zeros((self.size, self.size))
        x[: self.n], P[: self.n, : self.n] = mean, cov
        at = np.arange(self.n, self.size - 1)
        P[at, at] = self._zero_var
        return x, P

    def remember_growth(self, x: Array, P: Array) -> None:
        """Make the last state the growth at this instant: x_e = c z, with its covariances. Changes x and P."""
        copy = np.eye(self.size)
        copy[-1] = np.concatenate([self.growth, np.zeros(self.size - self.n)])
        x[:], P[:] = copy @ x, copy @ P @ copy.T

    def transition(self, z: Transition, dt: float) -> Transition:
        """F (size, size), J (size, n), Q (size, size) of the full state."""
        F, Q = np.eye(self.size), np.zeros((self.size, self.size))
        J = np.zeros((self.size, self.n))
        F[: self.n, : self.n], Q[: self.n, : self.n], J[: self.n] = z.F, z.Q, z.J
        at = np.arange(self.n, self.size - 1)
        Q[at, at] = self._walk_var * dt
        return Transition(F, J, Q)
