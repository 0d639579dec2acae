"""A hypothesis: some effects are missing, on what is taken as known of the model's own parameters."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

import numpy as np

from estimator.batch.trials import Trials
from estimator.hypotheses.candidates import APART_MM, Candidate
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.panel import Explanation, Panel
from estimator.hypotheses.slopes import Column
from estimator.model import Model, Value
from estimator.rig import Rig
from estimator.sensitivity.prior import Belief

ROUNDS = 4  # of steps, each with the slopes of its beginning
STEPS = 6
HALVINGS = 4
BOUND = 1e-3  # of a parameter's range: nearer to its end it is at it
DONE = 0.002  # share of the misfit: a step that gains less, or a round that can gain no more, is the last

NONE: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True)
class Hypothesis:
    """Effects to add, which parameters move with them, and the model that follows the recordings best so.

    names   of the effects, none: the model alone; of an effect that the model has: that one of its parameters is free
    judged  how well it predicts recordings left out, around its best values
    told    nats that the recordings tell of the parameters beyond their prior (`Panel.told`)
    freed   own parameter "effect.param" that alone is of another value than the ground says
    """

    names: tuple[str, ...]
    ground: Ground
    model: Model
    paths: tuple[str, ...]
    judged: Explanation
    told: float
    freed: str = ""

    def __str__(self) -> str:
        own = ", ".join(f"{path} {value} {self.model.param(path).unit}" for path, value in self.own().items())
        return f"{' + '.join(self.names) or 'the model alone'}: misfit {self.misfit:.4g}{', ' * bool(own)}{own}"

    @property
    def refit(self) -> bool:
        """Whether only tables hold the model's own parameters."""
        return self.ground.refit

    @property
    def misfit(self) -> float:
        """Mean square misfit on recordings left out, 1: as good as a good model."""
        return self.judged.misfit

    @property
    def cost(self) -> float:
        """Minus the logarithm of the evidence, but for a constant (Laplace), nats.

        n / 2 ln(misfit) + ln det(1 + S P^-1) / 2: what is left, and what had to be told of parameters for it
        """
        return 0.5 * self.judged.weight * float(np.log(self.misfit)) + self.told

    def known(self) -> Model:
        """The model with how well the parameters that moved are known."""
        return self.model.known(self.paths, self.judged.covariance)

    def own(self) -> dict[str, Value]:
        """Values and sd of the parameters of the effects to add."""
        values = self.known().values
        return {path: values[path] for path in self.paths if path.partition(".")[0] in self.names}

    def at_bound(self) -> list[str]:
        """Parameters of the effects to add that ended at a bound which is no null: of no size that can be.

        A place or a width may end where the screw does.
        """
        found = []
        for path in self.paths:
            param, value = self.model.param(path), float(self.model[path])
            near = BOUND * (param.hi - param.lo if np.isfinite(param.hi - param.lo) else max(abs(value), 1e-9))
            ends = [end for end in (param.lo, param.hi) if end != param.null]
            extent = param.unit == "mm" and param.null is None
            if path.partition(".")[0] in self.names and not extent and any(abs(value - end) <= near for end in ends):
                found.append(path)
        return found


def refined(
    ground: Ground, trials: Trials, added: Sequence[Candidate], first: Mapping[str, float] = NONE
) -> Hypothesis:
    """Follow the recordings with these effects, from the values `first` of some parameters.

    Gauss-Newton, in rounds of steps: within one the model's own parameters keep their slopes, in the first those that
    they have without the effects (Shamanskii 1967, for Newton's method).
    """
    wider = ground.model
    for each in added:
        wider = wider + each.effect if each.name not in wider.effects else wider
        wider = each.place(wider)
    own = [p for each in added for p in wider.free() if p.partition(".")[0] == each.name]
    paths = tuple(dict.fromkeys([*ground.paths, *own]))
    seen = partial(_panel, trials, paths, ground.belief(wider, paths))
    best, slopes_at = wider.with_values(first), ground.model
    panel = seen(slopes_at, best)
    for _ in range(ROUNDS):
        best = _walked(best, panel, partial(seen, slopes_at), trials[0].rig)
        panel, slopes_at = seen(best, best), best
        if panel.promise < DONE:
            break
    return Hypothesis(tuple(each.name for each in added), ground, best, paths, panel.judge(), panel.told)


def _walked(model: Model, panel: Panel, seen: Callable[[Model], Panel], rig: Rig) -> Model:
    """The model after steps, as long as they gain, or promise to."""
    for _ in range(STEPS if panel.columns else 0):
        before = panel.cost
        model, panel = _step(model, panel, seen, rig)
        if 1.0 - panel.cost / before < DONE or panel.promise < DONE:
            break
    return model


def _step(model: Model, panel: Panel, seen: Callable[[Model], Panel], rig: Rig) -> tuple[Model, Panel]:
    """One step, shortened until the misfit falls; none where it does not."""
    explained = panel.judge()
    for halving in range(HALVINGS):
        values = panel.values(explained, 0.5**halving)
        there = model.with_values({p: _inside(model, rig, p, value) for p, value in values.items()})
        after = seen(there)
        if after.cost < panel.cost:
            return there, after
    return model, panel


def _inside(model: Model, rig: Rig, path: str, value: float) -> float:
    """A value inside its bounds; a place moves a little at a time and stays on the screw."""
    param = model.param(path)
    lo, hi = param.lo, param.hi
    if param.over == "place":
        here, screw = model[path], rig.the_screw()
        lo, hi = max(lo, screw.from_mm, here - APART_MM), min(hi, screw.to_mm, here + APART_MM)
    return float(np.clip(value, lo, hi))


def _panel(trials: Trials, paths: Sequence[str], known: Belief, own: Model, model: Model) -> Panel:
    """Moments about a model; slopes of what another, `own`, has too are those that they have there."""
    return Panel.of(trials, model, [Column(model, path) for path in paths], known, own)
