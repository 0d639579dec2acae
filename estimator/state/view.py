"""From states to what a person asks for: elongation, profile, thermal error at the table's position."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimator.network import mesh
from estimator.network.assemble import Layout, growth, span_growth
from estimator.record import Array
from estimator.rig import Rig
from estimator.terms import SCREW, Term

PLACES = 99


class View:
    """Weights that turn the states z of one layout into lengths and profiles.

    growth   (n,) um/K of the measured span; zeros where the model has no screw (`has_span`)
    x_mm     (x,) places of the profile; `profile` (x, n) its weights
    bodies   nodes of one temperature, which stand `at_bodies` among the temperatures
    """

    def __init__(self, rig: Rig, place: Layout, terms: Sequence[Term]) -> None:
        self.rig, self.place, self._terms = rig, place, terms
        self.bodies, self.at_bodies = place.bodies, slice(len(place.knots_mm), place.size)
        screw = rig.screw if SCREW in place.nodes else None
        self._screw = screw
        self.has_span = screw is not None
        self.growth = span_growth(terms, rig, place)
        if screw is None:
            self.x_mm, self.profile = np.empty(0), np.empty((0, place.size))
            return
        self.x_mm = np.linspace(screw.from_mm, screw.to_mm, PLACES)
        self.profile = np.zeros((PLACES, place.size))
        knots = len(place.knots_mm)
        self.profile[:, :knots] = mesh.shapes(place.knots_mm, self.x_mm)

    def table_error(self, position_mm: Array | float) -> Array:
        """Weights (..., n) um/K of the growth between the anchor bearing and the nut's centre, positive = longer.

        NaN where the position is not known or the rig has no such thing.
        """
        rig, position = self.rig, np.asarray(position_mm, dtype=float)
        if self._screw is None or rig.nut is None or "anchor" not in rig.supports:
            return np.full((*position.shape, self.place.size), np.nan)
        anchor = rig.supports["anchor"].at_mm
        nut = np.where(np.isfinite(position), rig.nut.centre(position), anchor)
        weights = growth(self._terms, rig, self.place, np.minimum(nut, anchor), np.maximum(nut, anchor))
        return np.where(np.isfinite(position)[..., None], weights, np.nan)
