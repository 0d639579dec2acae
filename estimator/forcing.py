"""What the inputs do to the model, tick by tick: regime, heat and reading offsets.

Works on any number of ticks at once and remembers what it must between calls, so that a recording in one piece and a
bus tick by tick give the same numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimator import assemble
from estimator.discretise import Transition, transition
from estimator.inputs import Inputs
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.regime import Regimes
from estimator.rig import Rig
from estimator.start import Start


@dataclass(frozen=True)
class Ticks:
    """K ticks made ready for the filter.

    regime  (K,)    which transition
    heat    (K, n)  W into the states: sources and boundaries
    offset  (K, m)  what the channels read beside the temperatures
    """

    regime: Array
    heat: Array
    offset: Array


class Forcing:
    """Turns inputs into regimes, heat and offsets for one model on one rig, from one start."""

    def __init__(self, model: Model, rig: Rig, start: Start, reduced: bool = True) -> None:
        self.model, self.rig, self.start = model, rig, start
        self._regimes = Regimes()
        self._transitions: list[Transition] = []
        self._inflow: list[Array] = []
        self._last: dict[str, float] = {}
        self._first: dict[str, float] = {}
        self._coverage = np.zeros(rig.screw.cells if rig.screw else 0)
        terms = list(model.terms(self._inputs(None), rig))
        self.terms = terms
        self.place = assemble.layout(terms, rig, reduced)
        self.readings = assemble.readings(terms, rig, self.place)

    def transition(self, regime: int) -> Transition:
        """Transition of a regime."""
        return self._transitions[regime]

    def ticks(self, chunk: Recording) -> Ticks:
        """Make the ticks of a chunk ready; call in order of time."""
        u = self._inputs(chunk)
        regime = np.array([self._regimes.index(float(w), c) for w, c in zip(u.omega[:, 0], u.coverage, strict=True)])
        self._discretise()
        terms = list(self.model.terms(u, self.rig))
        heat = assemble.heat(terms, self.place, len(u))
        if self.place.boundaries:
            outside = np.hstack([u[name] for name in self.place.boundaries])
            for r in np.unique(regime):
                heat[regime == r] += outside[regime == r] @ self._inflow[r].T
        return Ticks(regime, heat, assemble.offsets(terms, self.rig, len(u)))

    def _discretise(self) -> None:
        """Assemble and discretise the regimes met since the last call."""
        new = range(len(self._transitions), len(self._regimes.omega))
        if not new:
            return
        none = {name: np.zeros((len(new), 1)) for name in self.rig.inputs}
        omega = np.array([[self._regimes.omega[r]] for r in new])
        u = Inputs(omega, np.array([self._regimes.coverage[r] for r in new]), none, none)
        network = assemble.network(self.model, self.rig, self.place, u)
        for i in range(len(new)):
            self._transitions.append(transition(network, i, self.rig.tick_s))
            self._inflow.append(network.inflow[i])

    def _inputs(self, chunk: Recording | None) -> Inputs:
        """Inputs with gaps held at the last known value, and temperatures zeroed at a steady start."""
        if chunk is None:
            none = {name: np.zeros((1, 1)) for name in self.rig.inputs}
            return Inputs(np.zeros((1, 1)), self._coverage[None, :], none, none)
        values, rises = {}, {}
        for name in self.rig.inputs:
            column = _held(chunk.inputs[name] - self.start.zero_K[name], self._last.get(name, np.nan))
            seen = column[np.isfinite(column)]
            if name not in self._first and len(seen):
                self._first[name] = float(seen[0])
            self._last[name] = float(column[-1])
            values[name] = np.where(np.isfinite(column), column, self.start.level_C)[:, None]
            rises[name] = np.nan_to_num(column - self._first.get(name, np.nan))[:, None]
        coverage = np.where(np.isnan(chunk.omega)[:, None], np.nan, chunk.coverage)
        for k in np.flatnonzero(np.isnan(coverage).any(axis=1)):
            coverage[k] = coverage[k - 1] if k else self._coverage
        self._coverage = coverage[-1].copy()
        return Inputs(np.nan_to_num(chunk.omega)[:, None], coverage, values, rises)


def _held(column: Array, before: float) -> Array:
    """The column with each gap filled by the value before it."""
    column = np.concatenate([[before], column])
    at = np.maximum.accumulate(np.where(np.isfinite(column), np.arange(len(column)), 0))
    return column[at][1:]
