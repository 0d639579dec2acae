"""What the estimate may be off by because parameters are: considered, never estimated (Schmidt 1966, Jazwinski 1970).

A true parameter is p + d, d with the covariance of a fit. To first order the true state is x + Z d for the open-loop
run and, as the filter follows the readings,

    Z <- F Z + dF z + d(J w)             how the open-loop run moves with each parameter
    S <- F S - K (H F S + D)             what the filter lacks of the rest, D: how the readings move

The thermometers' own gains and lags are parameters as well (own.py).

so that the true temperatures differ from the estimate by (S + Z) d beside the filter's own P, and the elongation alike.
Estimates do not change by it: their uncertainty does.
"""

import copy
from collections.abc import Iterator, Sequence

import numpy as np
import scipy

from estimator.effects.elsewhere import SHIFT, Elsewhere
from estimator.faults.machine import Known
from estimator.model import Model
from estimator.network.forcing import Drive, Ticks
from estimator.network.regime import rows_of
from estimator.record import Array
from estimator.rig import Rig
from estimator.state.moves import Course, Doubtful, Kernels, Moves, carried, followed
from estimator.state.open_loop import lag_filter
from estimator.state.own import OwnErrors
from estimator.state.run import Run
from estimator.state.tangent import Moved, MovedApart, ReadingsTangent

REMEMBERED = 64  # regimes whose derivatives are kept


class Doubt:
    """Carries the sensitivities of one run to its model's doubtful parameters, in order of time.

    kernels  what does it tick by tick: `carried` and `followed`, or those compiled
    known    how well the parameters are known, and then the thermometers' own errors
    """

    def __init__(self, run: Run, kernels: Kernels = (carried, followed)) -> None:
        self._carried, self._followed = kernels
        doubts = run.forcing.model.doubts
        self._run, self._start = run, run.x[run.state.temperatures]
        self._moved = [Moved(run.forcing, run.forcing.model, path) for path in doubts.paths]
        shifted = shifting(run.forcing.model, run.forcing.rig)
        self._moved += [Moved(run.forcing, shifted, SHIFT)] if shifted else []
        self._in_regimes = [i for i, moved in enumerate(self._moved) if moved.in_regimes]
        self._in_ticks = [i for i, moved in enumerate(self._moved) if moved.in_ticks]
        self._by_rows = [i for i in self._in_ticks if self._moved[i].by_rows]
        self._apart = MovedApart(run.forcing, [self._moved[i] for i in self._by_rows])
        readings = run.forcing.readings
        self._own = OwnErrors(readings, readings.rows @ self._start, run.forcing.rig.tick_s)
        q, self._paths = len(doubts.paths), tuple(moved.path for moved in self._moved)
        others = np.append(np.zeros(len(self._paths) - q), self._own.sd)
        together = scipy.linalg.block_diag(root(doubts.covariance), np.diag(others))
        self.known = Known(together, np.append(doubts.whole, 0.0 * others), q if shifted else None)
        first = np.zeros(len(run.offset))
        m, n, size = len(first), run.state.n, run.state.size
        found = [moved.readings(run, run.offset, first) or ReadingsTangent.none(m, n, size) for moved in self._moved]
        self._rows, self._growth, self._keep, self._ramp, x0 = (
            stacked([getattr(each, key) for each in found], shape)
            for key, shape in (("rows", (m, n)), ("growth", (n,)), ("keep", (m,)), ("ramp", (m,)), ("x0", (size,)))
        )
        self._zeros = np.array([run.state.channel_zeros(column) for column in x0.T]).reshape(-1, m).T
        self._Z = self._Z0 = np.ascontiguousarray(x0[run.state.temperatures])
        self._spot = np.einsum("mn,np->mp", run.forcing.readings.rows, self._Z) + self._start @ self._rows
        self._lagged, self._S = self._spot, np.zeros((size, len(together)))
        self._slopes: dict[int, Array] = {}

    def by(self, run: Run) -> "Doubt":
        """The same of the run by another model, of the parameters that it has too."""
        other = Doubt(run)
        at = [self._paths.index(path) for path in other._paths]
        for key in ("_Z", "_Z0", "_spot", "_lagged"):
            setattr(other, key, getattr(self, key)[:, at])
        other._S = self._S[:, [*at, *range(len(self._paths), len(self.known.whole))]]
        other._own = self._own
        return other

    def ahead(self, drive: Drive, ticks: Ticks, course: Course) -> Moves:
        """The next K ticks of the open-loop run, before anything of them is fused."""
        B, offset, own, pushed = self._pushes(drive, ticks, course)
        rows, lags = self._run.forcing.readings.rows, self._lags
        Z, D, self._spot, self._lagged = self._carried(
            *self._transitions(ticks.regime), B, own, pushed, offset + self._zeros, course.late_share, *lags,
            np.ascontiguousarray(rows), self._Z, self._spot, self._lagged,
        )  # fmt: skip
        growth = self._run.state.growth @ (Z - self._Z0)
        growth += (course.z[1:] - self._start) @ self._growth
        self._Z, D = Z[-1].copy(), np.concatenate([D, self._own.moved(course)], axis=2)
        return Moves(ticks.regime, course.grown_um, Z, D, growth)

    def behind(self, moves: Moves, gain: Array, off_share: Array) -> Doubtful:
        """What the next K ticks are off by, which the filter has updated with `gain` (K, size, m), 0: nothing fused.

        off_share  (K,) by which share of their values the parameters must be off beside what is known of them
        """
        states, growth = self.slopes(moves, gain)
        return Doubtful(self.known.doubtful(states, off_share), self.known.doubtful(growth, off_share))

    def slopes(self, moves: Moves, gain: Array) -> tuple[Array, Array]:
        """The same by each parameter: of states (K, size, p), of the elongation (K, p)."""
        state, grown, q = self._run.state, moves.grown_um, len(self._moved)
        H = state.rows(grown)
        S = self._followed(*self._transitions(moves.regime), H, gain, moves.readings, self._S)
        self._S = S[-1].copy()
        growth = (state.elongation(grown)[:, None] @ S)[:, 0]
        growth[:, :q] += moves.elongation
        S[:, state.temperatures, :q] += moves.states
        return S, growth

    def beside(self) -> "Doubt":
        """The same behind another filter of the run, from where this one is."""
        return copy.copy(self)

    def become(self, other: "Doubt") -> None:
        """Go on behind that other filter."""
        self._S = other._S

    @property
    def paths(self) -> tuple[str, ...]:
        """The model's doubtful parameters, in order, and then the position's shift, where there is a position."""
        return self._paths

    @property
    def own_sd(self) -> Array:
        """Of what thermometers' own gains and lags are off by, which come after the parameters."""
        return self._own.sd

    @property
    def _lags(self) -> tuple[Array, Array]:
        return lag_filter(self._run.forcing.readings.tau, self._run.forcing.rig.tick_s)

    def _transitions(self, regime: Array) -> tuple[Array, Array]:
        """F of the regimes that some ticks are in (R, n, n), and which one each is in, (K,)."""
        met, at = np.unique(regime, return_inverse=True)
        return np.array([self._run.forcing.transition(r).F for r in met.tolist()]), at

    def _pushes(self, drive: Drive, ticks: Ticks, course: Course) -> tuple[Array, Array, Array, Array]:
        """What of the sensitivities does not come from themselves: to states, readings, spots, lagged readings."""
        forcing, (heat, outside, offset) = self._run.forcing, self._own_pushes(drive, ticks)
        B, ends = np.zeros((*ticks.heat.shape, len(self._moved))), np.flatnonzero(outside.any(axis=(1, 2)))
        given = np.hstack([course.z[:-1], ticks.heat, ticks.outside])
        for r, slopes in self._regime_slopes(sorted(set(ticks.regime.tolist()))):
            at = rows_of(ticks.regime, r)
            put, moved = heat[:, at], B[at]
            put[ends] += outside[ends][:, at] @ forcing.inflow(r).T
            moved[:, :, self._in_regimes] = (given[at] @ slopes).reshape(*moved.shape[:2], -1)
            moved[:, :, self._in_ticks] += (put @ forcing.transition(r).J.T).transpose(1, 2, 0)
            if not isinstance(at, slice):
                B[at] = moved
        own_spot = np.tensordot(course.z[1:], self._rows, axes=(1, 1))
        pushed = (course.lagged - course.spot)[:-1, :, None] * self._keep
        pushed += np.diff(course.spot, axis=0)[:, :, None] * self._ramp
        return B, offset, own_spot, pushed

    def _own_pushes(self, drive: Drive, ticks: Ticks) -> tuple[Array, Array, Array]:
        """How what the model makes of K ticks moves with those of q parameters that move it, of r: heat (q, K, n),
        outside (q, K, boundaries), offset (K, m, r)."""
        K, some = len(ticks.regime), self._in_ticks
        heat, outside = np.zeros((len(some), *ticks.heat.shape)), np.zeros((len(some), *ticks.outside.shape))
        offset, alone = np.zeros((K, len(self._zeros), len(self._moved))), some
        if K == 1:  # a run of ticks is asked by each parameter, one tick by all of them: half of what a tick costs
            heat[[some.index(i) for i in self._by_rows], 0], rows = self._apart.tick(drive)
            offset[0][:, self._by_rows] = rows.T
            alone = [i for i in alone if i not in self._by_rows]
        for i in alone:
            own, k = self._moved[i].ticks(drive), some.index(i)
            heat[k], outside[k], offset[:, :, i] = own.heat, own.outside, own.offset
        return heat, outside, offset

    def _regime_slopes(self, met: Sequence[int]) -> Iterator[tuple[int, Array]]:
        """`regime_slopes` of each of these regimes; of those not met yet they are worked out together."""
        for first in range(0, len(met), REMEMBERED):
            some = met[first : first + REMEMBERED]
            new = [regime for regime in some if regime not in self._slopes]
            if len(self._slopes) + len(new) > REMEMBERED:
                self._slopes.clear()
                new = [*some]
            moved = [self._moved[i] for i in self._in_regimes]
            self._slopes |= zip(new, regime_slopes(moved, self._run, new), strict=True)
            yield from ((regime, self._slopes[regime]) for regime in some)


def regime_slopes(moved: Sequence[Moved], run: Run, regimes: Sequence[int]) -> list[Array]:
    """How a tick of each of some regimes moves the states (n,) with each of q parameters, by states, heat and
    boundaries (n + n + boundaries,) of the tick: matrices (n + n + boundaries, n q)."""
    q, n, boundaries = len(moved), run.state.n, run.forcing.place.boundaries
    networks, found = [each.network(regimes) for each in moved] if regimes else [], []
    for k, regime in enumerate(regimes):
        mass = np.array([each.mass for each in networks]).reshape(q, n, n)
        conductance = np.array([each.conductance[k] for each in networks]).reshape(q, n, n)
        inflow = np.array([each.inflow[k] for each in networks]).reshape(q, n, boundaries)
        by_states, by_heat = run.forcing.modes_of(regime).along(mass, conductance)
        slopes = np.concatenate([by_states, by_heat, run.forcing.transition(regime).J @ inflow], axis=2)
        found.append(slopes.transpose(2, 1, 0).reshape(2 * n + boundaries, n * q))
    return found


def shifting(model: Model, rig: Rig) -> Model | None:
    """The model with a shift of the position, none so far; None where the rig has no nut that moves."""
    moves = rig.screw is not None and rig.nut is not None and "position" in rig.inputs
    return (model + Elsewhere).with_values({SHIFT: 0.0}) if moves and Elsewhere.name not in model.effects else None


def stacked(columns: Sequence[Array], shape: tuple[int, ...]) -> Array:
    """Derivatives by each parameter side by side, (*shape, q)."""
    return np.stack(columns, axis=-1) if columns else np.zeros((*shape, 0))


def root(covariance: Array) -> Array:
    """A (p, p) with A A' = covariance, also where that is rounded to something that is not quite positive."""
    variance, ways = np.linalg.eigh(covariance)
    return np.asarray(ways * np.sqrt(np.maximum(variance, 0.0)))
