"""The inputs u of the model: measured and taken as exact, as columns over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from estimator.record import Array


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
        return self.values[name]

    def __contains__(self, name: str) -> bool:
        return name in self.values

    def rise(self, name: str) -> Array:
        """Change of an input since the start, (ticks, 1); 0 where the rig has no such input or it was never seen."""
        return self.rises.get(name, np.zeros_like(self.omega))
