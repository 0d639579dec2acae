"""Lengths of the screw, linear in its temperatures: growth of a span, and how far the nut moves from the anchor.

    growth of [a, b] = rho (1 + error) (integral of the rise over [a, b] - squeeze |[a, b] in [A, B]| / |AB| G)
    nut away from A  = growth of [A, nut] -+ give rho (1 + error) G,      G = integral of the rise over [A, B]

A and B are bearings that both hold the screw along its axis, where a model has such; A gives way outwards.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from estimator.record import Array
from estimator.rig import Rig
from estimator.terms import Expand, Hold, Term


class Growth:
    """Weights um/K on the cells' rises, (..., cells), by the terms of a model on a rig with a screw."""

    def __init__(self, terms: Sequence[Term], rig: Rig) -> None:
        self._screw = rig.the_screw()
        self._share = 1.0 + sum(term.error for term in terms if isinstance(term, Expand))
        self._holds = [term for term in terms if isinstance(term, Hold)]

    def span(self) -> Array:
        """Of the measured span, (cells,)."""
        return self.between(*self._screw.span_mm)

    def between(self, from_mm: Array | float, to_mm: Array | float) -> Array:
        """Of the screw between two places, the first of which is not beyond the second."""
        free = self._screw.growth(from_mm, to_mm)
        return np.asarray(self._share * sum((-self._squeezed(hold, from_mm, to_mm) for hold in self._holds), free))

    def away(self, anchor_mm: float, nut_mm: Array | float) -> Array:
        """Of the nut's way from the anchor bearing, positive: further from it."""
        growth = self.between(np.minimum(nut_mm, anchor_mm), np.maximum(nut_mm, anchor_mm))
        for hold in self._holds:
            inwards = np.sign(nut_mm - hold.anchor_mm) * np.sign(hold.by_mm - hold.anchor_mm)
            growth = growth - self._share * hold.give * np.multiply.outer(inwards, self._free(hold))
        return growth

    def _squeezed(self, hold: Hold, from_mm: Array | float, to_mm: Array | float) -> Any:
        lo, hi = sorted((hold.anchor_mm, hold.by_mm))
        inside = np.maximum(np.minimum(to_mm, hi) - np.maximum(from_mm, lo), 0.0)
        return hold.squeeze * np.multiply.outer(inside / (hi - lo), self._free(hold))

    def _free(self, hold: Hold) -> Array:
        """Growth between the bearings were the screw free there, (cells,)."""
        return self._screw.growth(*sorted((hold.anchor_mm, hold.by_mm)))
