"""A regime's continuous system into one tick, exactly, through the modes of its network.

Conductance G and mass M are symmetric, so that G s = rate M s has real rates and shapes S: S'MS = 1, S'GS = rates.
In these coordinates every integral of the discretisation is a scalar:

    F = S e^(-rates dt) S^-1        J = S psi(-rates) S'        Q = S (S'WS * psi(-rate_i - rate_j)) S'

with psi(x) = (e^(x dt) - 1) / x, W the noise and S^-1 = S'M.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from estimator.network.assemble import Network
from estimator.record import Array

CLOSE = 1e-4  # rates closer than this, over a tick, take the derivative instead of the divided difference


@dataclass(frozen=True)
class Transition:
    """One tick under one regime: z <- F z + J w, with covariance Q added.

    F  (n, n)
    J  (n, n)   K per W: response to a heat w, constant over the tick
    Q  (n, n)   K^2
    """

    F: Array
    J: Array
    Q: Array


class Modes:
    """The modes of one regime's network, from which a tick of dt s and its derivatives follow."""

    def __init__(self, network: Network, regime: int, dt: float) -> None:
        self._dt, self._mass = dt, network.mass
        self._rates, self._shapes = scipy.linalg.eigh(network.conductance[regime], network.mass)
        self._noise = self._shapes.T @ network.noise[regime] @ self._shapes

    def transition(self) -> Transition:
        """F, J and Q of one tick."""
        S, a, dt = self._shapes, -self._rates, self._dt
        Q = S @ (self._noise * _psi(a[:, None] + a, dt)) @ S.T
        return Transition((S * np.exp(a * dt)) @ S.T @ self._mass, (S * _psi(a, dt)) @ S.T, (Q + Q.T) / 2)

    def along(self, mass: Array, conductance: Array) -> tuple[Array, Array]:
        """How F and J move with mass and conductance, (..., n, n) each."""
        S, (of_F, of_J) = self._shapes, self._slopes
        to_A, to_J = -(S.T @ conductance @ S), 0.0
        if mass.any():
            to_mass = S.T @ mass @ S
            to_A, to_J = to_A + to_mass * self._rates, _psi(-self._rates, self._dt)[:, None] * to_mass
        return S @ (to_A * of_F) @ self._inverse, S @ (to_A * of_J - to_J) @ S.T

    @cached_property
    def _inverse(self) -> Array:
        """Of the shapes, (n, n)."""
        return np.asarray(self._shapes.T @ self._mass)

    @cached_property
    def _slopes(self) -> tuple[Array, Array]:
        """Divided differences (n, n) of what makes F and J of A: the same whatever moves."""
        a, dt = -self._rates, self._dt
        functions = (lambda x: np.exp(x * dt), lambda x: _psi(x, dt))
        of_F, of_J = (_divided(function, a[:, None], a[None, :], dt) for function in functions)
        return of_F, of_J

    def noise_slope(self, to_Q: Array) -> Array:
        """From a derivative with respect to Q (symmetric) to that with respect to the noise, (n, n)."""
        S, a = self._shapes, -self._rates
        return S @ (S.T @ to_Q @ S * _psi(a[:, None] + a, self._dt)) @ S.T


def transition(network: Network, regime: int, dt: float) -> Transition:
    """One tick of dt s under one regime."""
    return Modes(network, regime, dt).transition()


def _psi(x: Array, dt: float) -> Array:
    """(e^(x dt) - 1) / x; dt at x = 0."""
    small = np.abs(x) * dt < 1e-12
    safe = np.where(small, 1.0, x)
    return np.where(small, dt, np.expm1(safe * dt) / safe)


def _divided(function, x: Array, y: Array, dt: float) -> Array:  # type: ignore[no-untyped-def]
    """(f(x) - f(y)) / (x - y), and f' in the middle of two that are close."""
    apart = x - y
    close = np.abs(apart) * dt < CLOSE
    step = 0.5 * CLOSE / dt
    middle = (x + y) / 2
    return np.where(
        close,
        (function(middle + step) - function(middle - step)) / (2 * step),
        (function(x) - function(y)) / np.where(close, 1.0, apart),
    )
