"""The batch engine against plain numpy: the joint Gaussian of all states, and a filter with all channels at once."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch import batch
from estimator.batch.batch import ahead, compared, loglike, passes, score, smoothed
from estimator.batch.system import System

T, N, MOVING, CHANNELS, REGIMES = 30, 11, 6, 6, 2
SPAN = 4  # the channel with a dense row and an entry that varies


def random_system(seed: int = 0, ticks: int = T) -> System:
    """Two regimes; five constants, two of which walk; gaps, ticks without a reading, a channel without a model."""
    rng = np.random.default_rng(seed)
    F = np.array([0.8 * np.eye(MOVING) + 0.1 * rng.standard_normal((MOVING, MOVING)) for _ in range(REGIMES)])
    root = 0.3 * rng.standard_normal((REGIMES, MOVING, MOVING))
    Q = np.zeros((REGIMES, N, N))
    Q[:, :MOVING, :MOVING] = root @ root.transpose(0, 2, 1)
    Q[:, [7, 9], [7, 9]] = 0.01
    b = np.zeros((ticks, N))
    b[:, :MOVING] = rng.standard_normal((ticks, MOVING))
    H = np.where(rng.random((CHANNELS, N)) < 0.25, rng.standard_normal((CHANNELS, N)), 0.0)
    H[:, 0] = 1.0
    H[SPAN] = rng.standard_normal(N)
    y = 2.0 * rng.standard_normal((ticks, CHANNELS))
    y[rng.random(y.shape) < 0.3] = np.nan
    y[[0, 5, 6, ticks - 1]] = np.nan
    R = rng.uniform(0.2, 2.0, (ticks, CHANNELS))
    R[:, 2] = np.inf
    R[3, 1] = np.inf
    spans = np.zeros(CHANNELS)
    spans[[SPAN, 1]] = 0.7, -0.4
    start = rng.standard_normal((N, N))
    return System(
        y=y, regime=rng.integers(0, REGIMES, ticks), b=b, F=F, Q=Q, H=H, spans=spans, column=N - 2,
        grown=rng.standard_normal(ticks), R=R, x0=rng.standard_normal(N), P0=start @ start.T / N + 0.1 * np.eye(N),
        muted=rng.random(y.shape) < 0.1,
    )  # fmt: skip


def full(F: np.ndarray, n: int = N) -> np.ndarray:
    whole = np.eye(n, dtype=F.dtype)
    whole[: len(F), : len(F)] = F
    return whole


def rows(s: System, t: int) -> np.ndarray:
    H = s.H + 0.0 * s.grown[t]
    if s.column >= 0:
        H[:, s.column] += s.spans * s.grown[t]
    return H


def used(s: System, t: int) -> np.ndarray:
    use = np.isfinite(s.y[t].real) & np.isfinite(s.R[t].real)
    return use if s.muted is None else use & ~s.muted[t]


def plain(s: System, fuse: list[np.ndarray] | None = None) -> tuple[complex, list, list]:
    """Log-likelihood, predicted and filtered (x, P) of every tick; of complex numbers too, for derivatives."""
    x, P, total, before, after = s.x0, s.P0, 0.0, [], []
    for t in range(len(s.y)):
        F = full(s.F[s.regime[t]], len(x))
        x, P = F @ x + s.b[t], F @ P @ F.T + s.Q[s.regime[t]]
        before.append((x, P))
        use = used(s, t) if fuse is None else fuse[t]
        H = rows(s, t)[use]
        S = H @ P @ H.T + np.diag(s.R[t, use])
        e = s.y[t, use] - H @ x
        K = np.linalg.solve(S, H @ P).T
        total = total - 0.5 * (np.log(np.linalg.det(S)) + e @ np.linalg.solve(S, e) + len(e) * np.log(2 * np.pi))
        x, P = x + K @ e, P - K @ S @ K.T
        after.append((x, P))
    return total, before, after


def joint(s: System) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Mean and covariance of the states of all ticks in a row; rows, variances and values of all readings."""
    ticks, size = s.b.shape
    mean, cov = np.zeros((ticks, size)), np.zeros((ticks, size, ticks, size))
    x, P = s.x0, s.P0
    for t in range(ticks):
        F = full(s.F[s.regime[t]], size)
        x, P = F @ x + s.b[t], F @ P @ F.T + s.Q[s.regime[t]]
        mean[t], cov[t, :, t] = x, P
        for u in range(t):
            cov[t, :, u] = F @ cov[t - 1, :, u]
            cov[u, :, t] = cov[t, :, u].T
    H, R, y = np.zeros((ticks, len(s.H), ticks, size)), s.R.copy(), s.y.copy()
    for t in range(ticks):
        H[t, :, t] = rows(s, t)
        y[t, ~used(s, t)] = np.nan
    flat = ticks * size
    return mean.ravel(), cov.reshape(flat, flat), H.reshape(-1, flat), R.ravel(), y.ravel()


def given(s: System, ticks: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean and covariance of all states given the readings of the first ticks, and log-likelihood of those."""
    mean, cov, H, R, y = joint(s)
    use = np.isfinite(y) & (np.arange(len(y)) < ticks * len(s.H))
    H, R, e = H[use], R[use], y[use] - H[use] @ mean
    S = H @ cov @ H.T + np.diag(R)
    K = np.linalg.solve(S, H @ cov).T
    value = -0.5 * (np.linalg.slogdet(S)[1] + e @ np.linalg.solve(S, e) + len(e) * np.log(2 * np.pi))
    shape = s.b.shape
    return (mean + K @ e).reshape(shape), (cov - K @ H @ cov).reshape(*shape, *shape), value


@pytest.fixture
def system():
    return random_system()


@pytest.fixture(params=["whole", "chunked"])
def chunked(request, monkeypatch):
    """Every test twice: all ticks at once, and in chunks of a few."""
    if request.param == "chunked":
        monkeypatch.setattr(batch, "BUDGET", 16_000)
        monkeypatch.setattr(batch, "NEAR", 10_000)


def collected(s: System) -> dict[str, np.ndarray]:
    chunks = list(passes(s))
    assert [c.ticks.start for c in chunks[1:]] == [c.ticks.stop for c in chunks[:-1]]
    names = ("x", "P", "predicted", "sd", "fused", "gain", "nis", "loglike")
    return {name: np.concatenate([getattr(c, name) for c in chunks]) for name in names}


@pytest.mark.usefixtures("chunked")
def test_filtered_is_the_joint_gaussian_given_the_past(system):
    found = collected(system)
    for t in range(T):
        x, P, _ = given(system, t + 1)
        assert found["x"][t] == pytest.approx(x[t], abs=1e-9)
        assert found["P"][t] == pytest.approx(P[t, :, t], abs=1e-9)


def test_all_at_once_is_the_same_with_the_last_covariance_and_the_sds_asked_for(system):
    found, asked = collected(system), np.random.default_rng(3).random(system.y.shape) < 0.5
    at_once = compared(system, asked)
    for name in ("x", "predicted", "nis", "loglike"):
        np.testing.assert_array_equal(getattr(at_once, name), found[name])
    np.testing.assert_array_equal(at_once.P, found["P"][-1:])
    np.testing.assert_array_equal(at_once.sd, np.where(asked, found["sd"], np.nan))
    assert all(np.isnan(chunk.sd).all() for chunk in passes(system, spread=False))


@pytest.mark.usefixtures("chunked")
def test_predictions_compare_every_channel_whether_used_or_not(system):
    found, (_, before, _) = collected(system), plain(system)
    values = [0.0] + [given(system, t + 1)[2] for t in range(T)]
    assert found["loglike"] == pytest.approx(np.diff(values), abs=1e-9)
    for t, (x, P) in enumerate(before):
        H, use = rows(system, t), used(system, t)
        assert found["predicted"][t] == pytest.approx(H @ x, abs=1e-9)
        assert found["sd"][t] == pytest.approx(np.sqrt(np.diag(H @ P @ H.T) + system.R[t]), abs=1e-9)
        assert (found["fused"][t] == use).all()
        e, S = (system.y[t] - H @ x)[use], (H @ P @ H.T)[np.ix_(use, use)] + np.diag(system.R[t, use])
        expected = e @ np.linalg.solve(S, e) if use.any() else np.nan
        assert found["nis"][t] == pytest.approx(expected, abs=1e-9, nan_ok=True)
        assert found["gain"][t][:, use] == pytest.approx(P @ H[use].T @ np.linalg.inv(S), abs=1e-9)
        assert not found["gain"][t][:, ~use].any()
    assert np.isnan(found["nis"][[0, 5, 6, -1]]).all()
    assert np.isinf(found["sd"][:, 2]).all()


@pytest.mark.usefixtures("chunked")
def test_loglike_is_that_of_all_readings_at_once(system):
    assert loglike(system) == pytest.approx(given(system, T)[2], rel=1e-12)
    assert score(system).loglike == pytest.approx(loglike(system), rel=1e-13)


@pytest.mark.usefixtures("chunked")
def test_smoothed_is_the_joint_gaussian_given_all(system):
    x, P, _ = given(system, T)
    found = smoothed(system, covariances=True)
    assert found.x == pytest.approx(x, abs=1e-9)
    assert found.cov == pytest.approx(np.array([P[t, :, t] for t in range(T)]), abs=1e-9)
    assert found.var == pytest.approx(np.diagonal(found.cov, axis1=1, axis2=2), abs=1e-12)
    assert smoothed(system).var == pytest.approx(found.var, abs=1e-12)
    assert found.reading.shape == (T, 0)
    some = [CHANNELS - 1, 0]
    H, found = np.array([rows(system, t)[some] for t in range(T)]), smoothed(system, covariances=True, channels=some)
    assert found.reading == pytest.approx(np.einsum("tmi,ti->tm", H, x), abs=1e-9)
    assert found.reading_var == pytest.approx(np.einsum("tmi,tij,tmj->tm", H, found.cov, H), abs=1e-9)
    assert smoothed(system).cov.shape == (0, N, N)


STEP = 1e-30


def complex_slopes(s: System, name: str, symmetric: bool = False) -> np.ndarray:
    """Derivative of the plain log-likelihood by every entry of a field, exact by an imaginary step."""
    value = getattr(s, name)
    result = np.zeros(value.shape)
    for at in np.ndindex(value.shape):
        if not np.isfinite(value[at]):
            continue
        changed = value.astype(complex)
        changed[at] += 1j * STEP
        if symmetric and at[-1] != at[-2]:
            changed[(*at[:-2], at[-1], at[-2])] += 1j * STEP
        result[at] = plain(replace(s, **{name: changed}))[0].imag / STEP
    if symmetric:  # both entries were changed
        result *= 0.5 * (1.0 + np.eye(result.shape[-1]))
    return result


@pytest.mark.usefixtures("chunked")
@pytest.mark.parametrize("name", ["y", "R", "x0", "grown", "Q", "P0"])
def test_score_by(system, name):
    expected = complex_slopes(system, name, symmetric=name in ("Q", "P0"))
    found = getattr(score(system), name)
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-9 * np.abs(expected).max())


def test_without_a_varying_column_grown_is_nothing(system):
    flat = replace(system, column=-1)
    assert loglike(flat) == pytest.approx(loglike(replace(system, grown=np.zeros(T))), rel=1e-13)
    assert not score(flat).grown.any()


def test_ahead(system):
    _, _, after = plain(system)
    starts, readings = ahead(system, compared(system).x, steps=4, every=3)
    assert starts.tolist() == list(range(0, T - 4, 3))
    for start, found in zip(starts, readings):
        x = after[start][0]
        for t in range(start + 1, start + 5):
            x = full(system.F[system.regime[t]]) @ x + system.b[t]
        assert found == pytest.approx(rows(system, start + 4) @ x, abs=1e-11)
    assert len(ahead(system, compared(system).x, steps=T, every=1)[0]) == 0


def test_no_ticks_at_all(system):
    per_tick = ("y", "regime", "b", "grown", "R", "muted")
    empty = replace(system, **{name: getattr(system, name)[:0] for name in per_tick})
    assert loglike(empty) == 0.0
    assert not score(empty).P0.any()
    assert smoothed(empty, covariances=True).cov.shape == (0, N, N)
    assert [len(chunk.x) for chunk in passes(empty)] == [0]
    assert len(ahead(empty, compared(empty).x, 3, 3)[0]) == 0


def test_many_channels_and_entries_of_a_size_that_would_overflow():
    rng = np.random.default_rng(2)
    m = 90
    y = 1e-4 * rng.standard_normal((5, m))
    one = System(
        y=y, regime=np.zeros(5, dtype=int), b=np.zeros((5, 1)), F=np.ones((1, 1, 1)), Q=np.full((1, 1, 1), 1e-9),
        H=np.ones((m, 1)), spans=np.zeros(m), column=-1, grown=np.zeros(5), R=np.full((5, m), 1e-8), x0=np.zeros(1),
        P0=np.full((1, 1), 1e-8),
    )  # fmt: skip
    assert loglike(one) == pytest.approx(given(one, 5)[2], rel=1e-10)


def test_what_it_is_given_is_not_changed_and_may_be_read_only(system):
    before = {name: np.array(value) for name, value in vars(system).items()}
    expected, frozen = loglike(system), random_system()
    for value in vars(frozen).values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    assert loglike(frozen) == expected
    score(frozen), smoothed(frozen), list(passes(frozen)), ahead(frozen, compared(frozen).x, 3, 3)
    for name, value in before.items():
        np.testing.assert_array_equal(value, getattr(frozen, name))


def test_covariances_stay_symmetric_and_positive_over_a_million_ticks():
    rng, ticks, n = np.random.default_rng(4), 1_000_000, 8
    F = 0.999 * np.eye(7) + 0.001 * np.eye(7, k=1)
    long = System(
        y=np.where(rng.random((ticks, 3)) < 0.9, rng.standard_normal((ticks, 3)), np.nan),
        regime=np.zeros(ticks, dtype=int), b=np.zeros((ticks, n)), F=F[None], Q=1e-6 * np.eye(n)[None],
        H=np.eye(n)[[0, 3, 7]] + 0.1 * np.eye(n)[[1, 2, 6]], spans=np.array([0.0, 0.0, 1.0]), column=7,
        grown=np.sin(np.arange(ticks) / 1000.0), R=np.full((ticks, 3), 1e-2), x0=np.zeros(n), P0=1e2 * np.eye(n),
    )  # fmt: skip
    for chunk in passes(long):
        some = chunk.P[::97]
        assert (some == some.transpose(0, 2, 1)).all()
        assert np.linalg.eigvalsh(some).min() > 0.0
        assert (chunk.sd[::97] ** 2 > 1e-2).all()


def test_loglike_of_another_library():
    # statsmodels 0.15.0, tsa.statespace.kalman_filter.KalmanFilter (conventional, its default), on this very system:
    # initialize_known at F x0 + b and F P0 F' + Q of the first tick, transition and intercept of the next tick, unused
    # readings NaN
    assert loglike(random_system(seed=7, ticks=400)) == pytest.approx(-4237.980421226866, rel=1e-9)
