"""The score against the complex step of a likelihood that shares with it the terms only, and against differences."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm

from estimator.batch import batch
from estimator.batch.trial import Trial
from estimator.effect import Effect, Param
from estimator.effects.length import Displacement
from estimator.inputs.inputs import nothing
from estimator.model import Model, model_of
from estimator.network import assemble
from estimator.record import Array
from estimator.rig import Rig
from estimator.sensitivity.score import score
from estimator.sensitivity.tangent import tangent
from estimator.state.prior import prior
from estimator.terms import ELONGATION, SCREW, Heat, Read, Spot
from tests.conftest import SMALL, SMALL_VALUES

TICKS = 120
STEP = 1e-30
PARAMETERS = [f"{e.name}.{key}" for e in SMALL for key, param in e.params.items() if param.over != "channel"]
# without bearings, in the only drive of a run, and what is considered but never estimated
IDLE = {"friction_thinning.ratio", "churning.recovery", "thermometers.gain_sd", "thermometers.lag_sd"}
NOISE = {"noise", "sd", "lag_noise", "zero_sd", "zero_walk", "gain_sd", "lag_sd"}


# --- an independent likelihood, in complex numbers


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


# --- on the small rig, every parameter


MADE = {**SMALL_VALUES, "displacement.zero_sd": 2.0, "thermometers.board": 0.004, "thermometers.zero_sd": 0.05}
OTHER = {
    "nut_friction.power": 75.0, "nut_friction.n": 1.2, "thermometers.tau": 6.0, "thermometers.sd": 0.03,
    "nut_body.g": 3.0, "conduction.noise": 2.0, "expansion_error.error": 0.02,
}  # fmt: skip


def recorded(rig: Rig, model: Model, driven, live):
    """Drive and rest with gaps, silent ticks and late readings; everything around becomes warmer, each at its pace."""
    drive = driven(rig, TICKS * rig.tick_s, (15 * rig.tick_s, 80 * rig.tick_s), stroke=(0.0, 100.0))
    for i, name in enumerate(("ambient", "nut", "probe", "bar", "board"), start=1):
        drive.inputs[name][:] = 22 + i / 60 * np.arange(TICKS)
    run = live(model, rig, drive, seed=3, process=True).recording
    dice = np.random.default_rng(0)
    run.channels[1:][dice.random((TICKS - 1, len(rig.names))) < 0.3] = np.nan
    run.channels[0, 2] = run.channels[40:43] = np.nan
    return replace(run, ages_s=dice.uniform(0, 0.9, run.channels.shape))


@pytest.fixture(scope="module")
def made() -> Model:
    """Every effect of the catalogue that the small rig can serve."""
    return model_of(SMALL, "small").with_values(MADE)


@pytest.fixture(scope="module")
def trial(half, made, driven, live) -> Trial:
    """At two ticks a second: a tick that is forgotten shows."""
    return Trial(made, half, recorded(half, made, driven, live))


@pytest.fixture(scope="module")
def there(made) -> Model:
    """Not the model that the trial was made with: its lags stay those of the other."""
    return made.with_values(OTHER)


@pytest.fixture(scope="module")
def found(trial, there) -> tuple[float, dict[str, float]]:
    value, slopes = score(trial, there, list(there.values))
    return value, dict(zip(there.values, slopes, strict=True))


def slope(trial: Trial, model: Model, path: str, made_with: Model) -> float:
    """Derivative of the independent likelihood."""
    return likelihood(trial, model.with_values({path: model[path] + STEP * 1j}), made_with).imag / STEP


def test_the_recording_has_regimes_gaps_lags_and_late_readings(trial, there):
    posed = trial.pose(there)
    assert len(posed.system.F) > 3
    assert 0.3 < np.isnan(posed.system.y).mean() < 0.7
    assert not trial.muted.any()
    assert abs(posed.run.lag[:, :4]).max() > 0.5
    assert abs(posed.run.late).max() > 0.05
    assert abs(posed.run.grown).max() > 5


def test_the_value_is_the_likelihood(trial, there, made, found):
    value, _ = found
    assert value == pytest.approx(trial.loglike(there), rel=1e-9)
    assert value == pytest.approx(batch.loglike(trial.pose(there).system), rel=1e-9)
    assert value == pytest.approx(likelihood(trial, there, made).real, rel=1e-9)


@pytest.mark.parametrize("path", PARAMETERS)
def test_the_score_is_the_complex_step_of_an_independent_likelihood(path, trial, there, made, found):
    true = slope(trial, there, path, made)
    assert (true != 0) == (path not in IDLE)
    assert found[1][path] == pytest.approx(true, rel=1e-6)


def test_each_score_is_the_same_alone(trial, there, found):
    for path in ("thermometers.tau", "nut_body.g", "displacement.sd"):
        assert score(trial, there, [path])[1] == pytest.approx([found[1][path]], rel=1e-9)


def test_without_an_expansion_error_and_with_zeros_that_are_known(small, made, driven, live):
    """Other states: no unknown zeros but the displacement's, a coefficient that is exact; and a longer tick."""
    exact = replace(small, tick_s=2.0, screw=replace(small.screw, expansion_tolerance=0.0))
    known = (made - "expansion_error").with_values({"thermometers.zero_sd": 0.0})
    trial = Trial(known, exact, recorded(exact, known, driven, live))
    for path in ("nut_friction.power", "thermometers.tau", "thermometers.sd", "displacement.zero_walk"):
        true = slope(trial, known, path, known)
        assert score(trial, known, [path])[1] == pytest.approx([true], rel=1e-6), path


# --- a user's own effects


class Rub(Effect):
    """Something rubs at a place that is to be found, more where the nut is not.

    q = P exp(-((x - at) / 20 mm)^2 / 2)
    """

    power = Param(20.0, "W", lo=0.0, null=0.0)
    at = Param(70.0, "mm", lo=0.0, hi=200.0)
    noise = Param(0.2, "sqrt(s)", lo=0.0, hi=10.0)

    def terms(self, p, u, rig):
        near = np.exp(-0.5 * ((rig.screw.x_mm - p.at) / 20) ** 2) / 5
        q = p.power * (u.omega > 0)
        yield Heat(SCREW, q, over=near, noise=p.noise * q)
        yield Heat(SCREW, 0.2 * q, over=near * (1 - u.coverage))


class Gain(Effect):
    """A thermometer reads a share more than its temperature rise: y = T + gain (T - 22)."""

    gain = Param(0.03, "1", lo=-0.1, hi=0.1, null=0.0)

    def terms(self, p, u, rig):
        yield Read("T2", {SCREW: Spot(60.0, p.gain)}, 0.0, -22.0 * p.gain)


class Leaning(Displacement):
    """The probes stand askew: y = gain elongation + ..."""

    gain = Param(1.05, "1", lo=0.5, hi=2.0)

    def terms(self, p, u, rig):
        (reading,) = super().terms(p, u, rig)
        yield replace(reading, weights={ELONGATION: p.gain})


def own(small, made, effect, driven, live):
    """Score of an effect's parameters beside that of the independent likelihood."""
    model = (made - "displacement" if issubclass(effect, Displacement) else made) + effect
    trial = Trial(model, small, recorded(small, model, driven, live))
    paths = [f"{effect.name}.{key}" for key in effect.params]
    return score(trial, model, paths)[1], [slope(trial, model, path, model) for path in paths]


@pytest.mark.parametrize("effect", [Rub, Gain], ids=lambda e: e.name)
def test_a_users_own_effect_gets_its_score(effect, small, made, driven, live):
    found, true = own(small, made, effect, driven, live)
    assert np.all(true)
    np.testing.assert_allclose(found, true, rtol=1e-6)


def test_a_gain_of_the_displacement_gets_its_score(small, made, driven, live):
    found, true = own(small, made, Leaning, driven, live)
    np.testing.assert_allclose(found, true, rtol=1e-6)


# --- on the paper's rig


@pytest.fixture(scope="module")
def paper(rig, full, driven, live) -> Trial:
    drive = driven(rig, 200, (20, 120))
    for i, name in enumerate((name for name in rig.inputs if name != "position"), start=1):
        drive.inputs[name][:] = 22 + i / 200 * np.arange(200)
    return Trial(full, rig, live(full, rig, drive, seed=4, process=True).recording)


@pytest.mark.parametrize(
    ("path", "step"),
    [
        ("nut_friction.power", 0.3), ("nut_friction.n", 0.01), ("anchor_housing.g", 0.05), ("conduction.scale", 0.01),
        ("rotating_convection.h", 0.5), ("thermometers.tau", 0.05), ("thermometers.sd", 2e-4),
        ("nut_body.noise", 0.05), ("expansion_error.error", 0.002), ("displacement.probe", 0.02),
    ],
)  # fmt: skip
def test_the_score_on_the_paper_s_rig_is_that_of_differences(path, step, paper, full):
    def at(steps: int) -> float:
        return paper.loglike(full.with_values({path: full[path] + steps * step}))

    fourth_order = (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * step)
    assert score(paper, full, [path])[1][0] == pytest.approx(fourth_order, rel=1e-4)


def test_noise_levels_do_not_move_the_mean_and_all_others_do(paper, full):
    posed = paper.pose(full)
    moving = {path for path in full.values if tangent(paper, posed, full, path).moves_mean}
    assert moving == {path for path in full.values if path.partition(".")[2] not in NOISE}


def test_what_has_no_influence_moves_nothing(rig, full, driven, live):
    """At rest friction does nothing, and a board as warm as it was shifts no thermometer."""
    rest = Trial(full, rig, live(full, rig, driven(rig, 30, (30, 30)), seed=1).recording)
    paths = ["nut_friction.power", "nut_friction.noise", "thermometers.board", "displacement.bar"]
    assert score(rest, full, paths)[1] == pytest.approx(np.zeros(4), abs=1e-12)
    assert not any(tangent(rest, rest.pose(full), full, path).moves_mean for path in paths)
