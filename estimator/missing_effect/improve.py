"""Add what is missing, one effect at a time, until no effect helps any more.

Each step searches (`suggest`), adds what the verdict names, and begins again from that model; what earlier steps added
is fitted again with it, for it was found while the rest was missing. Of effects that these
recordings cannot tell apart the best is added, and its rivals are named. At the end all free parameters are fitted
again, where that predicts recordings left out better. A step that on the whole foretells the recordings held out worse
is told and not kept, and ends the search: they choose nothing else. A run with a wrong input, or within which something
began, is left out from there on. What no catalogue has is composed where that is asked for, and added like any effect.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from estimator.accuracy.horizon import open_loop_error
from estimator.accuracy.noise_floor import Error
from estimator.batch.trials import Trials, slow_trials_of, trials_of
from estimator.effect import Effect
from estimator.faults.use import Use
from estimator.hypotheses.criterion import clearly
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.hypothesis import Hypothesis, refined
from estimator.missing_effect.suggest import suggest
from estimator.missing_effect.suggestion import Suggestion
from estimator.missing_effect.wrong_always import inputs_in
from estimator.model import Model
from estimator.unknown.composed import Composed
from estimator.work import Runs, one_thread

MOST = 6  # steps: no machine of the studies lacked so much
MOST_COMPOSED = 3  # of them that add what no catalogue has
WORSE = 1.05  # times an error held out, from which on a step has made it worse


@dataclass(frozen=True)
class ImprovedModel:
    """One model on the way.

    added            the effect that it has more than the one before, or two; "" for the model as given, or fitted again
    tie              rivals that these recordings cannot tell from it
    cross_validated  open-loop error on recordings left out;  held_out: on those never looked at, None without any
    kept             whether it is gone on with
    """

    added: str
    tie: tuple[str, ...]
    model: Model
    cross_validated: Error
    held_out: Error | None
    kept: bool = True

    def worse(self, before: "ImprovedModel") -> dict[str, tuple[float, float]]:
        """Errors held out that are larger than they were `before`, by name: before and now."""
        if before.held_out is None or self.held_out is None:
            return {}
        both = {name: (was, getattr(self.held_out, name)) for name, was in vars(before.held_out).items()}
        return {name: (was, now) for name, (was, now) in both.items() if now > WORSE * was}

    def __str__(self) -> str:
        held_out = f"; held out {self.held_out}" if self.held_out else ""
        return f"{self.added or 'no effect more':32} cross-validated {self.cross_validated}{held_out}"


@dataclass(frozen=True)
class Improvement:
    """All steps, from the model as given to the best, and the last verdict; None: stopped by Ctrl-C before it.

    uses   what was used of each recording, those held out too, by the model as given
    apart  what is wrong with a run that was left out, or began within it, for each of them
    composed  effects that no catalogue has, in the order in which they were added
    """

    steps: tuple[ImprovedModel, ...]
    last: Suggestion | None
    uses: tuple[Use, ...]
    apart: tuple[Suggestion, ...] = ()
    composed: tuple[Composed, ...] = ()

    def __repr__(self) -> str:
        """Its steps, and the last verdict."""
        return "\n".join([*map(str, self.steps), self.last.verdict if self.last else "stopped"])

    @property
    def model(self) -> Model:
        """The best model."""
        return self.kept[-1].model

    @property
    def kept(self) -> list[ImprovedModel]:
        """The steps on the way to it."""
        return [step for step in self.steps if step.kept]

    @property
    def left_out(self) -> set[str]:
        """Names of recordings that the best model was not fitted to."""
        return {one.apart for one in self.apart}


@one_thread
def improve(
    model: Model,
    runs: Runs,
    held_out: Runs,
    effects: Sequence[type[Effect]],
    compose: Collection[str] | None = None,
) -> Improvement:
    """Improve a model. Ctrl-C keeps the best so far.

    compose  names of effects that an effect that no catalogue has must not get; None: none is composed
    """
    trials, held = slow_trials_of(model, runs), trials_of(model, held_out)
    uses, steps = trials.uses + held.uses, [_step((), (), refined(Ground(model, ()), trials, []), held)]
    added, apart, made = list[str](), list[Suggestion](), list[Composed]()
    try:
        while True:
            found = suggest(model, _heard(runs, len(steps)), effects, added, taken=compose or ())
            if found.apart:
                apart.append(found)
                runs, found = found.kept(runs), found.others
                steps = _judged_anew(steps, runs)
            if found.believed:
                steps = _judged_anew(steps, runs, found.believed)
            best = _next(found, compose is not None and len(made) < MOST_COMPOSED)
            if best is None or len(steps) > MOST:
                break
            tie = tuple(n for n in found.tie if n not in best.names)
            steps.append(_kept(_step(best.names, tie, best, held), steps[-1]))
            if not steps[-1].kept:
                break
            if found.composed is not None and found.composed.hypothesis is best:
                made.append(found.composed)
            model, added = _onwards(best, runs), [*added, *best.names]
        last = _fitted(found) if steps[-1].kept else None
        if last is not None:
            steps.append(_kept(_step((), (), last, held), steps[-1]))
    except KeyboardInterrupt:
        return Improvement(tuple(steps), None, uses, tuple(apart), tuple(made))
    return Improvement(tuple(steps), found, uses, tuple(apart), tuple(made))


def _next(found: Suggestion, compose: bool) -> Hypothesis | None:
    """What a verdict adds to the model; None where nothing is to be added."""
    if found.verdict in ("effect", "tie", "effects"):
        return None if inputs_in(found.tie) else found.found[0]
    if compose and found.verdict == "nothing_in_catalogue" and found.composed is not None:
        return found.composed.hypothesis
    return None


def _judged_anew(steps: Sequence[ImprovedModel], runs: Runs, believed: Sequence[str] = ()) -> list[ImprovedModel]:
    """The steps so far, by what is heard now of which recordings: or what leaves one out would look like what helps."""
    trials = slow_trials_of(steps[0].model, runs, believed)
    errors = [refined(Ground(step.model, ()), trials, []).judged.error for step in steps]
    return [replace(step, cross_validated=error) for step, error in zip(steps, errors, strict=True)]


def _onwards(h: Hypothesis, runs: Runs) -> Model:
    """The model that the next step begins with.

    What an earlier fit knew is known to the next step as well, no better: these recordings count once. A model fitted
    to them says so.
    """
    if not h.refit:
        return h.model.with_values({path: h.ground.model.values[path] for path in h.ground.learned})
    fitted_on = {recording.name: recording.fingerprint for recording in runs.recordings}
    return replace(h.model, about={**h.model.about, "fitted_on": fitted_on})


def _heard(runs: Runs, step: int) -> Runs:
    """The same runs, whose progress tells the step too."""
    return replace(runs, progress=lambda stage, done: runs.progress(f"step {step}: {stage}", done))


def _fitted(found: Suggestion) -> Hypothesis | None:
    """The model, or one parameter, fitted again, where that predicts clearly better and nothing else is wrong."""
    if found.verdict in ("input_error", "nothing_in_catalogue"):
        return None
    if found.changed:
        return found.found[0]
    better = found.before.refit and clearly(found.as_given.judged, found.before.judged, 1)
    return found.before if better else None


def _step(added: tuple[str, ...], tie: tuple[str, ...], h: Hypothesis, held_out: Trials) -> ImprovedModel:
    model = h.known()
    held = open_loop_error(model, held_out) if len(held_out) else None
    return ImprovedModel(" + ".join(added), tie, model, h.judged.error, held)


def _kept(step: ImprovedModel, before: ImprovedModel) -> ImprovedModel:
    """The step, kept unless errors held out have become larger, and more so than others have become smaller."""
    if not step.worse(before):
        return step
    ratios = [now / was for was, now in zip(_errors(before), _errors(step), strict=True) if was > 0 and now > 0]
    return replace(step, kept=math.prod(ratios) <= 1.0)


def _errors(step: ImprovedModel) -> list[float]:
    return list(vars(step.held_out).values())
