"""From states to what a person asks for: elongation, profile, thermal error at the table's position."""

from collections.abc import Sequence

import numpy as np

from estimator.faults.fault import Fault
from estimator.network import mesh
from estimator.network.assemble import span_growth
from estimator.network.forcing import Forcing
from estimator.network.growth import Growth
from estimator.network.layout import Layout
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.terms import SCREW, Hold, Term

PLACES = 99
UNSEEN_K_PER_H = 1.0  # that a bed goes while its thermometer is silent: air in a shop goes about as fast


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
        """Weights (..., n) um/K of how far the nut's centre moves away from the place of the anchor bearing.

        That is the growth between them, less what the bearing gives way where another one holds the screw too.

        NaN where the position is not known or the rig has no such thing.
        """
        rig, position = self.rig, np.asarray(position_mm, dtype=float)
        if self._screw is None or rig.nut is None or "anchor" not in rig.supports:
            return np.full((*position.shape, self.place.size), np.nan)
        anchor = rig.supports["anchor"].at_mm
        nut = np.where(np.isfinite(position), rig.nut.centre(position), anchor)
        weights = Growth(self._terms, rig).away(anchor, nut) @ self.place.rows(SCREW)
        return np.where(np.isfinite(position)[..., None], weights, np.nan)


class Mounting:
    """What the error at the table is in doubt by where two bearings hold the screw.

        var = g' rho g,      g_i = (w(p_i + sd_i) - w(p_i)) (z - z_0)

    w are the weights of `View.table_error`, p_i the parameters that say how the screw is held, rho how their errors
    correlate. What they do to temperatures and elongation is the matter of doubt.py, and is added apart.
    """

    def __init__(self, view: View, forcing: Forcing) -> None:
        model, rig = forcing.model, forcing.rig
        holding = {name for name in model.effects if _holds(model.terms_of(name, forcing.nothing, rig))}
        self._view = view
        self._paths = [path for path in model.doubts.paths if path.partition(".")[0] in holding]
        covariance = model.covariance(self._paths)
        sd = np.sqrt(np.diag(covariance))
        self._rho = covariance / np.outer(sd, sd)
        others = [model.with_values({path: model[path] + x}) for path, x in zip(self._paths, sd, strict=True)]
        self._moved = [View(rig, forcing.place, list(other.terms(forcing.nothing, rig))) for other in others]

    def variance(self, at_mm: Array, rise: Array) -> Array:
        """Of the growth at places (p,), or (K, p), mm, at rises (K, n) of the states: (K, p) um2."""
        if not self._moved:
            return np.zeros((len(rise), 1))
        usual = self._view.table_error(at_mm)
        g = np.array([((view.table_error(at_mm) - usual) * rise[:, None]).sum(axis=-1) for view in self._moved])
        return np.asarray(np.einsum("ikp,ij,jkp->kp", g, self._rho, g))


def _holds(terms: Sequence[Term]) -> bool:
    return any(isinstance(term, Hold) for term in terms)


class BedGrowth:
    """What the table's place is told by grows between anchor bearing and nut; nothing where the rig has no bed.

        um = expansion (T - T_0) |x_nut - x_anchor|,      T_0 at the first tick, or the rig's zero_C

    Its thermometer is read in order of time; what it showed last holds while it is silent or broken, and is the less
    sure the longer that lasts.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig, self._zero = rig, rig.zero_C
        self._last, self._last_s = np.nan, 0.0
        self._rise = self._unseen_K = np.zeros(1)

    def read(self, rows: Recording, fault: Array) -> None:
        """The next ticks, with why each input was held, (K, p), a Fault each."""
        if self._rig.bed is None:
            return
        name = self._rig.bed.input
        well = np.where(fault[:, list(self._rig.inputs).index(name)] == Fault.NONE, rows.inputs[name], np.nan)
        series, time_s = np.append(self._last, well), np.append(self._last_s, rows.time_s)
        known = np.isfinite(series)
        at = np.maximum.accumulate(np.where(known, np.arange(len(series)), 0))
        if self._zero is None and known.any():
            self._zero = float(series[np.argmax(known)])
        self._last, self._last_s = series[at[-1]], time_s[at[-1]]
        self._rise = series[at][1:] - (np.nan if self._zero is None else self._zero)
        self._unseen_K = (time_s - time_s[at])[1:] / 3600.0 * UNSEEN_K_PER_H

    def um(self, at_mm: Array) -> tuple[Array, Array]:
        """Growth with the table at places (p,), or (K, p), mm, and its sd: (K, p) each, of the ticks read last."""
        rig = self._rig
        if rig.bed is None or rig.nut is None:
            return np.zeros((1, 1)), np.zeros((1, 1))
        reach_mm = abs(rig.nut.centre(at_mm) - rig.supports["anchor"].at_mm)
        um_per_K = rig.bed.expansion * 1e3 * reach_mm
        um = um_per_K * self._rise[:, None]
        return um, np.hypot(um * rig.bed.tolerance, um_per_K * self._unseen_K[:, None])
