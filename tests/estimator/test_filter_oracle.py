"""The filter against one large normal distribution of all states, noises and readings, conditioned by brute force."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import block_diag

from estimator.filter import Filter
from estimator.inputs.start import read_start
from estimator.network.forcing import Forcing
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.state import report
from estimator.state.prior import prior
from tests.conftest import stepped

SAMPLES = 8


@pytest.fixture(scope="module", autouse=True)
def no_lies():
    """That lengths may lie is no part of the joint distribution."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report, "LENGTHS_LIE", 0.0)
        yield


@pytest.fixture(scope="module")
def small_model(small_model):
    """Without what is considered, and no part of the joint distribution: the thermometers' own errors."""
    return small_model.with_values({"thermometers.gain_sd": 0.0, "thermometers.lag_sd": 0.0})


@pytest.fixture(scope="module", params=["small", "half"])
def ticking(request) -> Rig:
    """The small rig at a tick of 1 s, and of half a second."""
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="module")
def recording(ticking, small_model, driven, live) -> Recording:
    """Eight samples with gaps: a thermometer silent, a tick without any channel, displacement now and then, late."""
    tick_s = ticking.tick_s
    drive = driven(ticking, SAMPLES * tick_s, (2 * tick_s, 6 * tick_s), stroke=(0.0, 100.0))
    inputs = {**drive.inputs, "ambient": 22 + 0.3 * np.arange(SAMPLES), "board": 22 + np.arange(SAMPLES) / 2}
    lived = live(small_model, ticking, replace(drive, inputs=inputs), seed=3).recording
    lived.channels[3:5, 1] = np.nan
    lived.channels[5] = np.nan
    lived.channels[7, 4] = lived.channels[6, 4] + 0.3
    ages = np.zeros_like(lived.channels)
    ages[:, 4] = 0.3
    return replace(lived, ages_s=ages)


@dataclass
class Joint:
    """Everything linear in the independent b ~ N(0, cov): x_k = A_k b + a_k, y_k = C_k b + c_k.

    x holds the temperatures, the displacement's zero and the error of the expansion coefficient; b their start, all
    process noise and all measurement noise.
    """

    cov: Array
    states: list[tuple[Array, Array]]
    readings: list[tuple[Array, Array]]

    def given(self, y: Array, ticks: int) -> tuple[Array, Array]:
        """Mean and covariance of b when the readings of the first `ticks` ticks are known."""
        known = np.isfinite(y[:ticks])
        C = np.vstack([self.readings[k][0][known[k]] for k in range(ticks)])
        c = np.concatenate([self.readings[k][1][known[k]] for k in range(ticks)])
        gain = np.linalg.solve(C @ self.cov @ C.T, C @ self.cov).T
        return gain @ (y[:ticks][known] - c), self.cov - gain @ C @ self.cov


def lags(spots: Array, tau: Array, dt: float) -> Array:
    """Reading minus spot of each channel at the ticks, the equation solved numerically: (K, m)."""
    values, lagged = [np.zeros_like(spots[0])], spots[0]
    slow = tau > 0
    for a, b in pairwise(spots):
        way = solve_ivp(
            lambda t, s, a=a, b=b: np.where(slow, (a + (b - a) * t / dt - s) / np.where(slow, tau, 1.0), 0.0),
            (0, dt), lagged, rtol=1e-12, atol=1e-12,
        )  # fmt: skip
        lagged = np.where(slow, way.y[:, -1], b)
        values.append(lagged - b)
    return np.array(values)


def span_growth(rig, place) -> Array:
    """Growth of the measured span, 10 to 190 mm, um per K of each state, (n,)."""
    edges = rig.screw.edges_mm
    mm = np.clip(np.minimum(edges[1:], 190) - np.maximum(edges[:-1], 10), 0, None)
    return 12e-6 * mm * 1e3 @ place.shapes[:20]


def joint(model, rig, recording: Recording) -> tuple[Joint, Array]:
    """The distribution, from the matrices of every tick; and the open-loop growth since the first sample, (K,) um."""
    first = recording.sample(0)
    start = read_start(first, rig)
    forcing = Forcing(model, rig, start)
    ticks, readings = forcing.ticks(forcing.read(recording)), forcing.readings
    n, m, K = forcing.place.size, len(rig.names), len(recording)
    mean, cov = prior(start, forcing.terms, forcing.place, first.inputs)
    is_growth = np.array([not rig.channels[name].is_thermometer for name in rig.names])
    own = np.flatnonzero(readings.zero_sd)  # channels with an unknown zero
    walk, last = np.diag(readings.zero_walk[own] ** 2 * rig.tick_s), n + len(own)
    moves = [forcing.transition(r) for r in ticks.regime]

    def build(offset: Array, R: Array, grown_um: Array) -> Joint:
        tolerance = rig.screw.expansion_tolerance
        noises = [block_diag(move.Q, walk, 0.0) for move in moves[1:]]
        zeros = np.diag(readings.zero_sd[own] ** 2)
        sizes = block_diag(cov, zeros, tolerance**2, *noises, *[np.diag(r) for r in R])
        A, a = np.eye(last + 1, len(sizes)), np.append(mean, np.zeros(len(own) + 1))
        states, outputs = [], []
        for k, (move, heat) in enumerate(zip(moves, ticks.heat, strict=True)):
            if k:
                A = block_diag(move.F, np.eye(len(own) + 1)) @ A + np.eye(last + 1, len(sizes), k * (last + 1))
                a = np.append(move.F @ a[:n] + move.J @ heat, a[n:])
            noise = np.eye(m, len(sizes), K * (last + 1) + k * m)
            H = np.column_stack([readings.rows, np.eye(m)[:, own], is_growth * grown_um[k]])
            states.append((A, a))
            outputs.append((H @ A + noise, H @ a + offset[k]))
        return Joint(sizes, states, outputs)

    at_first = np.where(np.arange(K) == 0, 0.3**2, 0.0)[:, None]  # the first reading has nothing to be checked against
    alone = build(np.zeros((K, m)), readings.sd**2 + at_first, np.zeros(K))
    A, a = alone.states[0]
    runs = [(A @ alone.given(recording.channels, 1)[0] + a)[:n]]
    for move, heat in zip(moves[1:], ticks.heat[1:], strict=True):
        runs.append(move.F @ runs[-1] + move.J @ heat)
    spots = np.array(runs) @ readings.rows.T
    lag = lags(spots, readings.tau, rig.tick_s)
    late = np.vstack([np.zeros(m), -np.diff(spots, axis=0) * recording.ages_s[1:] / rig.tick_s])
    offset = np.vstack([np.zeros(m), ticks.offset[1:]]) + lag + late
    grown_um = (np.array(runs) - runs[0]) @ span_growth(rig, forcing.place)
    return build(offset, readings.sd**2 + (readings.lag_noise * lag) ** 2 + at_first, grown_um), grown_um


@pytest.fixture(scope="module", params=[0.01, 0.3, 0.0], ids=lambda tolerance: f"tolerance {tolerance}")
def both(request, ticking, small_model, recording):
    """The filter after the last sample, its track, the joint distribution and the open-loop growth."""
    rig = replace(ticking, screw=replace(ticking.screw, expansion_tolerance=request.param))
    filter_ = Filter(small_model, rig)
    track = stepped(filter_, recording)
    return filter_, track, *joint(small_model, rig, recording)


def test_the_recording_has_gaps_and_more_than_one_regime(both, recording, ticking):
    filter_, track, _, grown_um = both
    np.testing.assert_array_equal(track.fused, np.isfinite(recording.channels))
    assert list(track.nis_channels) == [5, 4, 4, 4, 3, 0, 5, 5]
    assert len(filter_._transitions) > 1
    assert abs(grown_um).max() > 0.7 * ticking.tick_s


def test_the_open_loop_growth_is_the_one_that_acts_on_the_coefficient(both):
    _, track, _, grown_um = both
    np.testing.assert_allclose(track.open_loop_um, grown_um, rtol=0, atol=1e-9)


def test_the_final_state_is_that_of_the_joint_distribution(both, recording):
    filter_, _, whole, _ = both
    b, cov = whole.given(recording.channels, SAMPLES)
    A, a = whole.states[-1]
    np.testing.assert_allclose(filter_.fusion.x[:-1], A @ b + a, rtol=0, atol=1e-9)
    np.testing.assert_allclose(filter_.fusion.P[:-1, :-1], A @ cov @ A.T, rtol=0, atol=1e-9)


def test_elongation_and_sigma_are_those_of_the_growth_since_the_first_sample(both, ticking, recording):
    """The model's growth and, by another coefficient, a share of what the model alone has grown."""
    filter_, track, whole, grown_um = both
    growth = span_growth(ticking, filter_.run.forcing.place)
    for ticks in (1, 4, 6, SAMPLES):
        b, cov = whole.given(recording.channels, ticks)
        (now, a), (before, a0) = whole.states[ticks - 1], whole.states[0]
        row = growth @ (now - before)[:4] + grown_um[ticks - 1] * now[-1]
        mean = growth @ (a - a0)[:4] + grown_um[ticks - 1] * a[5]
        assert track.elongation_um[ticks - 1] == pytest.approx(row @ b + mean, abs=1e-9)
        assert track.sigma_um[ticks - 1] == pytest.approx(np.sqrt(max(row @ cov @ row, 0)), abs=1e-6)


def test_from_a_zero_the_elongation_and_its_sd_are_those_of_the_temperatures(ticking, small_model, recording):
    """Off together by zero_sd_K, all thermometers make the growth of the whole span wrong."""
    rig = replace(ticking, zero_C=19.0, zero_sd_K=0.05)
    filter_ = Filter(small_model, rig)
    track = stepped(filter_, recording)
    whole, grown_um = joint(small_model, rig, recording)
    growth = span_growth(rig, filter_.run.forcing.place)
    (A, a), (b, cov) = whole.states[0], whole.given(recording.channels, 1)
    began = growth @ ((A @ b + a)[:4] - 19.0)
    assert began > 3.0
    for ticks in (1, 4, SAMPLES):
        (now, a), (b, cov) = whole.states[ticks - 1], whole.given(recording.channels, ticks)
        row = growth @ now[:4] + (began + grown_um[ticks - 1]) * now[-1]
        variance = row @ cov @ row + (180 * 12e-3 * 0.05) ** 2
        assert track.elongation_um[ticks - 1] == pytest.approx(row @ b + growth @ (a[:4] - 19.0), abs=1e-9)
        assert track.sigma_um[ticks - 1] == pytest.approx(np.sqrt(variance), abs=1e-6)
        assert track.open_loop_um[ticks - 1] == pytest.approx(began + grown_um[ticks - 1], abs=1e-9)


def test_innovations_and_nis_are_those_of_each_reading_given_all_before(both, recording):
    _, track, whole, _ = both
    for k in range(1, SAMPLES):
        b, cov = whole.given(recording.channels, k)
        C, c = whole.readings[k]
        known = np.isfinite(recording.channels[k])
        e, S = recording.channels[k] - (C @ b + c), C @ cov @ C.T
        np.testing.assert_allclose(track.innovation[k][known], e[known], rtol=0, atol=1e-8)
        np.testing.assert_allclose(track.innovation_sd[k], np.sqrt(np.diag(S)), rtol=0, atol=1e-8)
        if known.any():
            nis = e[known] @ np.linalg.solve(S[np.ix_(known, known)], e[known])
            assert track.nis[k] == pytest.approx(nis, rel=1e-6)
