"""A likelihood in complex numbers that shares with the engine the terms only."""

from itertools import pairwise

import numpy as np
from scipy.linalg import expm

from estimator.batch.trial import Trial
from estimator.inputs.inputs import nothing
from estimator.model import Model
from estimator.network import assemble
from estimator.record import Array
from estimator.state.prior import prior


def discretised(A: Array, W: Array, dt: float) -> tuple[Array, Array, Array]:
    """e^(A dt), its integral, and the covariance of white noise W over a tick (Van Loan 1978)."""
    n, none, one = len(A), np.zeros_like(A), np.eye(len(A))
    F = expm(A * dt)
    integral = expm(np.block([[A, one], [none, none]]) * dt)[:n, n:]
    return F, integral, F @ expm(np.block([[-A, W], [none, A.T]]) * dt)[:n, n:]


def lagged(tau: Array, spots: Array, dt: float) -> Array:
    """Answer of a first-order lag to spots (K, m) with straight lines between them, in equilibrium at first."""
    out, lags = [spots[0]], tau != 0
    left = np.where(lags, np.exp(-dt / np.where(lags, tau, 1.0)), 0.0)
    for before, now in pairwise(spots):
        behind = tau * (now - before) / dt
        out.append(now - behind + (out[-1] - before + behind) * left)
    return np.array(out)


class Plain:
    """What the terms say of a recording: the system of each regime, heat, offsets and readings; complex where they are.

    The growth alone and the lags follow from an open-loop run from the first estimate.
    """

    def __init__(self, trial: Trial, model: Model) -> None:
        rig, u, dt = trial.rig, trial.drive.inputs, trial.rig.tick_s
        regime, forcing = trial.drive.regime, trial.pose(real(model)).forcing
        place, self.n = forcing.place, forcing.place.size
        terms = list(model.terms(u, rig))
        regimes = forcing.regime_inputs()
        system = assemble.network_of(list(model.terms(regimes, rig)), place, len(regimes))
        invert = np.linalg.inv(system.mass)
        per_regime = zip(system.conductance, system.noise, strict=True)
        moves = [discretised(-invert @ G, invert @ W @ invert.T, dt) for G, W in per_regime]
        inflow = np.einsum("tij,tj->ti", system.inflow[regime], assemble.outside(terms, u, place))
        heat = assemble.heat(terms, place, len(u)) + inflow
        self.F = [moves[r][0] for r in regime]
        self.b = [moves[r][1] @ invert @ w for r, w in zip(regime, heat, strict=True)]
        self.Q = [moves[r][2] for r in regime]
        self.offset = assemble.offsets(terms, rig, len(u))
        self.readings = assemble.readings(list(model.terms(nothing(rig), rig)), rig, place)
        self.own = np.flatnonzero(self.readings.zero_sd)
        self.dt, self.tolerance = dt, rig.expansion_tolerance
        self.first = self._first(trial, *prior(trial.run.start, terms, place, trial.run.sample.inputs))
        z = [self.first[0][: self.n]]
        for F, b in zip(self.F[1:], self.b[1:], strict=True):
            z.append(F @ z[-1] + b)
        spots = np.array(z) @ self.readings.rows.T
        self.grown = (np.array(z) - z[0]) @ self.readings.growth
        self.lag = lagged(self.readings.tau, spots, dt) - spots
        late = np.clip(trial.rest.ages_s / dt, 0, 1) * np.diff(spots, axis=0)
        self.beside = self.offset[1:] + self.lag[1:] - late

    def rows(self, grown: Array) -> Array:
        """H: temperatures, unknown zeros, the error of the expansion coefficient."""
        zeros = np.eye(len(self.readings.sd))[:, self.own]
        return np.column_stack([self.readings.rows, zeros, self.readings.spans * grown])

    def _first(self, trial: Trial, mean: Array, cov: Array) -> tuple[Array, Array, complex]:
        size = self.n + len(self.own) + 1
        x, P = np.zeros(size, complex), np.zeros((size, size), complex)
        x[: self.n], P[: self.n, : self.n] = mean, cov
        at = np.arange(self.n, size)
        P[at, at] = np.append(self.readings.zero_sd[self.own], self.tolerance) ** 2
        R = self.readings.sd**2 + 0.3**2
        return fused(x, P, trial.run.sample.channels - self.offset[0], self.rows(0.0), R)


def fused(x: Array, P: Array, y: Array, H: Array, R: Array) -> tuple[Array, Array, complex]:
    """State after the readings that are there, and their log-likelihood."""
    use = np.isfinite(y.real) & np.isfinite(R.real)
    H, e = H[use], y[use] - H[use] @ x
    S = H @ P @ H.T + np.diag(R[use])
    K = P @ H.T @ np.linalg.inv(S)
    value = -0.5 * (np.log(np.linalg.det(2 * np.pi * S)) + e @ np.linalg.solve(S, e))
    return x + K @ e, P - K @ H @ P, value


def real(model: Model) -> Model:
    return model.with_values({path: float(np.real(model[path])) for path in model.values})


def likelihood(trial: Trial, model: Model, made_with: Model) -> complex:
    """Log-likelihood after the first sample; lags add the scatter that the trial's own model says."""
    p = Plain(trial, model)
    lag, total = Plain(trial, made_with).lag, 0.0
    x, P, _ = p.first
    walk = np.append(p.readings.zero_walk[p.own], 0.0) ** 2 * p.dt
    for k, y in enumerate(trial.rest.channels, start=1):
        F, Q = np.eye(len(x), dtype=complex), np.zeros_like(P)
        F[: p.n, : p.n], Q[: p.n, : p.n] = p.F[k], p.Q[k]
        Q[np.arange(p.n, len(x)), np.arange(p.n, len(x))] = walk
        x, P = F @ x, F @ P @ F.T + Q
        x[: p.n] += p.b[k]
        R = p.readings.sd**2 + (p.readings.lag_noise * lag[k].real) ** 2
        x, P, value = fused(x, P, y - p.beside[k - 1], p.rows(p.grown[k]), R)
        total += value
    return total
