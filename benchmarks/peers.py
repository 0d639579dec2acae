"""Other packages on the same problem, each called the way that costs it least: what one would take instead of ours."""

import importlib
from typing import Any

import numpy as np

from benchmarks.problem import Problem
from estimator.record import Array

LOG_2PI = np.log(2 * np.pi)
PEERS = ("statsmodels", "jax", "dynamax")


def check_peers() -> None:
    """All of them are here, or one line says what to do."""
    for name in PEERS:
        try:
            importlib.import_module(name)
        except ImportError as error:
            raise SystemExit(
                f"{name}: {error}; `make bench-engine` installs it (or pip install -e '.[bench]')"
            ) from None


class Statsmodels:
    """Its conventional filter in compiled code; loglike() keeps nothing of the single steps."""

    def __init__(self, problem: Problem) -> None:
        from statsmodels.tsa.statespace.kalman_filter import KalmanFilter

        n, m = len(problem.x0), len(problem.H)
        self._filter = KalmanFilter(k_endog=m, k_states=n, k_posdef=n)
        self._filter.bind(np.asfortranarray(problem.y.T))
        self._filter["selection"] = np.eye(n)
        self.assign(problem)

    def assign(self, problem: Problem) -> None:
        """Other parameters. It wants one transition a step, and that into the next one."""
        following = np.append(problem.regime[1:], problem.regime[-1])
        b = problem.b
        self._filter["transition"] = problem.F.transpose(0, 2, 1).copy()[following].T
        self._filter["state_intercept"] = np.vstack([b[1:], b[-1:]]).T
        self._filter["state_cov"] = problem.Q
        self._filter["design"] = problem.H
        self._filter["obs_cov"] = np.diag(problem.R)
        self._filter.initialize_known(*problem.first)

    def loglike(self) -> float:
        """Log-likelihood by the parameters assigned last."""
        return float(self._filter.loglike())

    def loglike_of(self, problem: Problem) -> float:
        """Log-likelihood by other parameters."""
        self.assign(problem)
        return self.loglike()


class Dynamax:
    """Compiled by JAX for this shape beforehand. It knows no gaps: a reading without a row of H stands for one."""

    def __init__(self, problem: Problem) -> None:
        import jax
        from dynamax.linear_gaussian_ssm.inference import lgssm_filter, lgssm_smoother

        jax.config.update("jax_enable_x64", True)
        gaps = np.isnan(problem.y)
        self._free = float((0.5 * (LOG_2PI + np.log(problem.R)) * gaps).sum())  # what those readings cost
        H = np.where(gaps[:, :, None], 0.0, problem.H)
        self._data = [jax.device_put(a) for a in (np.nan_to_num(problem.y), problem.regime, H)]
        self._args = self._put(problem)

        def loglike(data: Any, args: Any) -> Any:
            return lgssm_filter(_params(data, args), data[0]).marginal_loglik

        def smoothed(data: Any, args: Any) -> Any:
            found = lgssm_smoother(_params(data, args), data[0])
            return found.marginal_loglik, found.smoothed_means, found.smoothed_covariances

        self._loglike, self._smoothed = jax.jit(loglike), jax.jit(smoothed)

    def loglike(self) -> float:
        """Log-likelihood by the problem's own parameters."""
        return float(self._loglike(self._data, self._args)) + self._free

    def loglike_of(self, problem: Problem) -> float:
        """Log-likelihood by other parameters (that of the gaps' stand-ins taken along)."""
        gaps = 0.5 * (np.log(problem.R) + LOG_2PI) @ np.isnan(problem.y).sum(axis=0)
        return float(self._loglike(self._data, self._put(problem))) + float(gaps)

    def smoothed(self) -> tuple[Array, Array]:
        """Means (T, n) and covariances (T, n, n) of all steps from all readings."""
        _, x, P = self._smoothed(self._data, self._args)
        return np.asarray(x), np.asarray(P)

    @staticmethod
    def _put(problem: Problem) -> list[Any]:
        import jax

        mean, cov = problem.first
        return [jax.device_put(a) for a in (problem.F, problem.b, problem.Q, np.diag(problem.R), mean, cov)]


def _params(data: Any, args: Any) -> Any:
    """The problem as dynamax takes it: F by step through a function, so that it is not repeated."""
    import jax.numpy as jnp
    from dynamax.linear_gaussian_ssm import inference as lgssm

    (_, regime, H), (F, b, Q, R, mean, cov) = data, args
    n, m = b.shape[1], H.shape[1]
    return lgssm.ParamsLGSSM(
        initial=lgssm.ParamsLGSSMInitial(mean=mean, cov=cov),
        dynamics=lgssm.ParamsLGSSMDynamics(
            weights=lambda t: F[regime[t]], bias=b, input_weights=jnp.zeros((n, 0)), cov=Q
        ),
        emissions=lgssm.ParamsLGSSMEmissions(weights=H, bias=jnp.zeros(m), input_weights=jnp.zeros((m, 0)), cov=R),
    )
