"""A linear system of any size with readings drawn from it: the same arrays for us and for everyone else.

A shaft in cells with a nut and two bearings on it, the air around, an error of the friction heat that dies away, and
the unknown zero of the displacement, last because it does not move. Six speeds make six regimes.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm

from estimator.batch.system import System
from estimator.record import Array

SPEEDS = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 3.0])
THERMOMETERS = 15
BESIDE = 6  # states that are no cell of the shaft
HOLD_S, GAP_S, BETWEEN_GAPS_S = 300.0, 60.0, 6600.0
READ = 0.3  # share of the steps at which the displacement is read


@dataclass(frozen=True)
class Problem:
    """x <- F x + B u + w and y = H x + e at each of T steps, from x ~ (x0, P0) before the first.

    F (6, n, n), Q (n, n), B (n, 4), H (16, n), R (16,), u (T, 4), regime (T,), y (T, 16) with NaN: not measured
    """

    F: Array
    Q: Array
    B: Array
    H: Array
    R: Array
    x0: Array
    P0: Array
    regime: Array
    u: Array
    y: Array

    @property
    def b(self) -> Array:
        """What the inputs add to the states, (T, n)."""
        return self.u @ self.B.T

    @property
    def first(self) -> tuple[Array, Array]:
        """Mean and covariance at the first step before its readings: from here most others begin."""
        F = self.F[self.regime[0]]
        return F @ self.x0 + self.B @ self.u[0], F @ self.P0 @ F.T + self.Q

    @property
    def missing(self) -> float:
        """Share of the temperatures that were not measured."""
        return float(np.isnan(self.y[:, :THERMOMETERS]).mean())

    def system(self) -> System:
        """The problem as our engine takes it."""
        return System(
            y=self.y, regime=self.regime, b=self.b, F=self.F[:, :-1, :-1], Q=np.array([self.Q] * len(self.F)),
            H=self.H, spans=np.zeros(len(self.H)), column=-1, grown=np.zeros(len(self.y)),
            R=np.broadcast_to(self.R, self.y.shape), x0=self.x0, P0=self.P0,
        )  # fmt: skip

    def other(self, factor: float) -> "Problem":
        """Other parameters on the same readings: heat that spreads and is made faster by a factor."""
        return replace(self, F=transitions(len(self.x0), factor), B=self.B * factor, R=self.R * factor)


def make(states: int = 22, steps: int = 28_800, seed: int = 5) -> Problem:
    """Draw a problem."""
    dice = np.random.default_rng(seed)
    shaft = states - BESIDE
    regime = _regimes(steps, dice)
    sd = np.full(states, 0.002)
    sd[shaft + 3], sd[-1] = 0.0005, 0.02
    start = np.ones(states)
    start[-2], start[-1] = 0.5, 5.0
    B = np.zeros((states, 4))
    B[shaft : shaft + 4] = np.diag([4e-3, 3e-3, 2e-3, 5e-4])
    R = np.full(THERMOMETERS + 1, 0.05**2)
    R[-1] = 0.5**2
    problem = Problem(
        F=transitions(states), Q=np.diag(sd**2), B=B, H=_rows(shaft), R=R, x0=np.zeros(states), P0=np.diag(start**2),
        regime=regime, u=_inputs(regime, dice), y=np.empty((steps, len(R))),
    )  # fmt: skip
    return replace(problem, y=_readings(problem, dice))


def transitions(states: int, factor: float = 1.0) -> Array:
    """F of each speed."""
    return np.array([expm(factor * _network(states, speed)) for speed in SPEEDS])


def _network(states: int, speed: float) -> Array:
    """dx/dt = A x, 1/s."""
    A = np.zeros((states, states))
    shaft = states - BESIDE
    nut, bearings, air, error = shaft, (shaft + 1, shaft + 2), shaft + 3, shaft + 4

    def flow(into: int, source: int, rate: float) -> None:
        A[into, source] += rate
        A[into, into] -= rate

    loss = 1 / 4000
    for i in range(shaft):
        for j in (i - 1, i + 1):
            if 0 <= j < shaft:
                flow(i, j, (shaft / 16) ** 2 / 60)
        flow(i, air, loss * (1 + 0.8 * speed))
    middle = range(shaft * 3 // 8, shaft * 5 // 8)
    for i in middle:
        flow(i, nut, 1 / 1200)
        flow(nut, i, 1 / 600 / len(middle))
    for bearing, end in zip(bearings, (0, shaft - 1)):
        flow(bearing, end, 1 / 200)
        flow(end, bearing, 1 / 200)
        flow(bearing, air, 2 * loss)
    flow(nut, air, 1.5 * loss)
    A[nut, error] += 1e-3 * speed
    A[error, error] -= 1 / 3600
    A[air, air] -= 1 / 20_000
    return A


def _rows(shaft: int) -> Array:
    """Eight thermometers on cells, three between two cells, four on what is beside the shaft; the displacement."""
    H = np.zeros((THERMOMETERS + 1, shaft + BESIDE))
    H[np.arange(8), np.linspace(0, shaft - 2, 8).round().astype(int)] = 1.0
    for channel, i in zip((8, 9, 10), np.linspace(1, shaft - 2, 3).astype(int)):
        H[channel, i : i + 2] = 0.6, 0.4
    H[np.arange(11, 15), shaft + np.arange(4)] = 1.0
    H[-1, :shaft], H[-1, -1] = 0.575 * 16 / shaft, 1.0
    return H


def _regimes(steps: int, dice: np.random.Generator) -> Array:
    regime, t = np.empty(steps, dtype=np.int64), 0
    while t < steps:
        hold = 1 + int(dice.exponential(HOLD_S))
        regime[t : t + hold] = dice.integers(len(SPEEDS))
        t += hold
    return regime


def _inputs(regime: Array, dice: np.random.Generator) -> Array:
    """Heat of the nut under a varying load and of both bearings, and the air's day, (T, 4)."""
    speed, steps = SPEEDS[regime], len(regime)
    load = 10 * np.convolve(dice.standard_normal(steps + 599), np.full(600, 1 / 600), "valid")
    day = np.sin(2 * np.pi * np.arange(steps) / 28_800)
    return np.column_stack([speed * (1.5 + 0.5 * load), speed, speed, day])


def _readings(problem: Problem, dice: np.random.Generator) -> Array:
    """Live through it, read, and lose some of the readings."""
    shape = (steps, channels) = problem.y.shape
    b, walk = problem.b, dice.standard_normal((steps, len(problem.x0))) * np.sqrt(np.diag(problem.Q))
    x, states = dice.multivariate_normal(problem.x0, problem.P0), np.empty_like(b)
    for t in range(steps):
        x = states[t] = problem.F[problem.regime[t]] @ x + b[t] + walk[t]
    y = states @ problem.H.T + dice.standard_normal(shape) * np.sqrt(problem.R)
    y[dice.random(steps) >= READ, -1] = np.nan
    for channel in range(channels - 1):
        t = int(dice.exponential(BETWEEN_GAPS_S))
        while t < steps:
            gap = 1 + int(dice.exponential(GAP_S))
            y[t : t + gap, channel] = np.nan
            t += gap + int(dice.exponential(BETWEEN_GAPS_S))
    return y
