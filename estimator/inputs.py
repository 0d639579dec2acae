"""The inputs u of the model: measured and taken as exact, as columns over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from estimator.errors import SetupError, nearest
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.start import Start


@dataclass(frozen=True)
class Inputs:
    """Inputs of `ticks` ticks. Every scalar is a column (ticks, 1), so that it broadcasts against a place (cells,).

    omega     rad/s, mean of |speed| over the tick
    coverage  (ticks, cells) share of the tick in which the nut covers each cell
    values    other inputs by name, in the rig file's unit
    rises     their changes since they were first seen; 0 before that
    """

    omega: Array
    coverage: Array
    values: Mapping[str, Array]
    rises: Mapping[str, Array]

    def __len__(self) -> int:
        return len(self.omega)

    def __getitem__(self, name: str) -> Array:
        if name not in self.values:
            raise SetupError(
                f"needs the input '{name}', which rig.toml has not in [inputs]; {nearest(name, self.values)}; add it "
                "or leave the effect out"
            )
        return self.values[name]

    def __contains__(self, name: str) -> bool:
        return name in self.values

    def rise(self, name: str) -> Array:
        """Change of an input since the start, (ticks, 1); 0 where the rig has no such input or it was never seen."""
        return self.rises.get(name, np.zeros_like(self.omega))


class InputReader:
    """Recordings into inputs: gaps held at the last known value, temperatures zeroed at a steady start.

    Before an input was ever seen a temperature is at the level of the thermometers, anything else at zero.
    """

    def __init__(self, rig: Rig, start: Start) -> None:
        self._rig, self._start = rig, start
        self._last: dict[str, float] = {}
        self._first: dict[str, float] = {}
        self._coverage = np.zeros(rig.screw.cells if rig.screw else 0)

    def nothing(self) -> Inputs:
        """One tick at rest with every input at zero: enough to ask a model for its structure."""
        none = {name: np.zeros((1, 1)) for name in self._rig.inputs}
        return Inputs(np.zeros((1, 1)), np.zeros((1, len(self._coverage))), none, none)

    def read(self, chunk: Recording) -> Inputs:
        """Inputs of the next ticks; call in order of time."""
        values, rises = {}, {}
        for name in self._rig.inputs:
            column = _held(chunk.inputs[name] - self._start.zero_K[name], self._last.get(name, np.nan))
            seen = column[np.isfinite(column)]
            if name not in self._first and len(seen):
                self._first[name] = float(seen[0])
            self._last[name] = float(column[-1])
            unseen = self._start.level_C if self._rig.inputs[name].unit == "degC" else 0.0
            values[name] = np.where(np.isfinite(column), column, unseen)[:, None]
            rises[name] = np.nan_to_num(column - self._first.get(name, np.nan))[:, None]
        coverage = np.array(chunk.coverage, dtype=float)
        for k in np.flatnonzero(np.isnan(chunk.omega) | np.isnan(coverage).any(axis=1)):
            coverage[k] = coverage[k - 1] if k else self._coverage
        self._coverage = coverage[-1].copy()
        return Inputs(np.nan_to_num(chunk.omega)[:, None], coverage, values, rises)


def _held(column: Array, before: float) -> Array:
    """The column with each gap filled by the value before it."""
    column = np.concatenate([[before], column])
    at = np.maximum.accumulate(np.where(np.isfinite(column), np.arange(len(column)), 0))
    return column[at][1:]
