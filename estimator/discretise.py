"""A regime's continuous system into one tick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from estimator.assemble import Network
from estimator.record import Array

SHORT = 4.0  # of the fastest mode's own time


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


def transition(network: Network, regime: int, dt: float) -> Transition:
    """Exact discretisation over dt for heat constant over the tick (Van Loan 1978).

    His matrix holds exp(-A dt) too, which swamps Q where a mode dies out within a tick: so a part of the tick is
    discretised, short enough for the fastest mode, and doubled until it is the tick.
    """
    n = len(network.mass)
    inverse = np.linalg.inv(network.mass)
    a = -inverse @ network.conductance[regime]
    w = inverse @ network.noise[regime] @ inverse.T
    parts = max(1.0, float(np.linalg.norm(a, 1)) * dt / SHORT)
    doublings = int(np.ceil(np.log2(parts)))
    dt /= 2**doublings
    block = np.zeros((2 * n, 2 * n), np.result_type(a, w))
    block[:n, :n], block[:n, n:], block[n:, n:] = a, w, -a.T
    both = expm(block * dt)
    F = both[:n, :n]
    Q = both[:n, n:] @ F.T
    heat = np.zeros((2 * n, 2 * n), block.dtype)
    heat[:n, :n], heat[:n, n:] = a, inverse
    J = expm(heat * dt)[:n, n:]
    for _ in range(doublings):
        F, J, Q = F @ F, F @ J + J, F @ Q @ F.T + Q
    return Transition(F, J, (Q + Q.T) / 2)
