"""A hypothesis: some effects are missing, and the model's other parameters are right as they are, or fitted again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from estimator.batch.trials import Trials
from estimator.missing_effect.candidates import APART_MM, Candidate
from estimator.missing_effect.moments import Column
from estimator.missing_effect.panel import Explanation, Panel
from estimator.model import Model, Value
from estimator.rig import Rig

ROUNDS = 6
HALVINGS = 4
DONE = 0.01  # a round that gains less than this share of the misfit is the last

NONE: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True)
class Hypothesis:
    """Effects to add, which parameters move with them, and the model that follows the recordings best so.

    names   of the effects, none: the model alone
    refit   whether the model's own free parameters move too
    judged  how well it predicts recordings left out, around its best values
    """

    names: tuple[str, ...]
    refit: bool
    model: Model
    paths: tuple[str, ...]
    judged: Explanation

    @property
    def misfit(self) -> float:
        """Mean square misfit on recordings left out, 1: as good as a good model."""
        return self.judged.misfit

    def known(self) -> Model:
        """The model with how well the parameters that moved are known."""
        return self.model.known(self.paths, self.judged.covariance)

    def own(self) -> dict[str, Value]:
        """Values and sd of the parameters of the effects to add."""
        values = self.known().values
        return {path: values[path] for path in self.paths if path.partition(".")[0] in self.names}


def refined(
    model: Model,
    trials: Trials,
    added: Sequence[Candidate],
    refit: bool,
    first: Mapping[str, float] = NONE,
    only: Sequence[str] = (),
) -> Hypothesis:
    """Follow the recordings with these effects, in steps (Gauss-Newton), from the values `first` of some parameters.

    only  the model's own parameters that move where `refit` is not asked for
    """
    wider = model
    for each in added:
        wider = wider + each.effect if each.name not in wider.effects else wider
        wider = each.place(wider)
    own = [p for each in added for p in wider.free() if p.partition(".")[0] == each.name]
    paths = tuple(dict.fromkeys([*(model.free() if refit else only), *own]))
    wider = wider.with_values(first)
    best, panel = wider, _panel(wider, trials, paths)
    cost = panel.cost
    for _ in range(ROUNDS if paths else 0):
        there, seen = _step(best, panel, paths, trials, cost)
        if there is None:
            break
        gained = 1.0 - seen.cost / cost
        best, panel, cost = there, seen, seen.cost
        if gained < DONE:
            break
    return Hypothesis(tuple(each.name for each in added), refit, best, paths, panel.judge())


def _step(
    model: Model, panel: Panel, paths: Sequence[str], trials: Trials, cost: float
) -> tuple[Model, Panel] | tuple[None, Panel]:
    """One step, shortened until the misfit falls; None where it does not."""
    explained = panel.judge()
    for halving in range(HALVINGS):
        values = panel.values(explained, 0.5**halving)
        there = model.with_values({p: _inside(model, trials[0].rig, p, value) for p, value in values.items()})
        if _cost(there, trials, paths) < cost:
            return there, _panel(there, trials, paths)
    return None, panel


def _inside(model: Model, rig: Rig, path: str, value: float) -> float:
    """A value inside its bounds; a place moves a little at a time and stays on the screw."""
    param = model.param(path)
    lo, hi = param.lo, param.hi
    if param.over == "place":
        here, screw = model[path], rig.the_screw()
        lo, hi = max(lo, screw.from_mm, here - APART_MM), min(hi, screw.to_mm, here + APART_MM)
    return float(np.clip(value, lo, hi))


def _cost(model: Model, trials: Trials, paths: Sequence[str]) -> float:
    """The misfit alone, priors of the parameters included."""
    return Panel.of(trials, model, []).cost_with([Column(model, path) for path in paths])


def _panel(model: Model, trials: Trials, paths: Sequence[str]) -> Panel:
    return Panel.of(trials, model, [Column(model, path) for path in paths])
