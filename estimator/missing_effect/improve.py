"""Add what is missing, one effect at a time, until no effect helps any more.

Each step searches (`suggest`), adds what the verdict names, and begins again from that model; what earlier steps added
is fitted again with it, for it was found while the rest was missing. Of effects that these
recordings cannot tell apart the best is added, and its rivals are named. At the end all free parameters are fitted
again, where that predicts recordings left out better.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from estimator.accuracy.horizon import open_loop_error
from estimator.accuracy.noise_floor import Error
from estimator.batch.trials import Trials, slow_trials_of, trials_of
from estimator.effect import Effect
from estimator.faults.use import Use
from estimator.missing_effect.hypothesis import Hypothesis, refined
from estimator.missing_effect.suggest import suggest
from estimator.missing_effect.suggestion import MATERIAL, Suggestion
from estimator.model import Model
from estimator.work import Runs

MOST = 6


@dataclass(frozen=True)
class ImprovedModel:
    """One model on the way.

    added            the effect that it has more than the one before; "" for the model as given, or fitted again
    tie              rivals that these recordings cannot tell from it
    cross_validated  open-loop error on recordings left out;  held_out: on those never looked at, None without any
    """

    added: str
    tie: tuple[str, ...]
    model: Model
    cross_validated: Error
    held_out: Error | None


@dataclass(frozen=True)
class Improvement:
    """All steps, from the model as given to the best, and the last verdict; None: stopped by Ctrl-C before it.

    uses  what was used of each recording, those held out too, by the model as given
    """

    steps: tuple[ImprovedModel, ...]
    last: Suggestion | None
    uses: tuple[Use, ...]

    @property
    def model(self) -> Model:
        """The best model."""
        return self.steps[-1].model


def improve(model: Model, runs: Runs, held_out: Runs, effects: Sequence[type[Effect]]) -> Improvement:
    """Improve a model. Ctrl-C keeps the best so far."""
    trials, held = slow_trials_of(model, runs), trials_of(model, held_out)
    uses, steps = trials.uses + held.uses, [_step("", (), refined(model, trials, [], False), held)]
    try:
        while True:
            found = suggest(steps[-1].model, _heard(runs, len(steps)), effects, [step.added for step in steps])
            taken = _taken(found) if len(steps) <= MOST else None
            if taken is None:
                break
            name = taken.names[0] if taken.names else ""
            steps.append(_step(name, tuple(n for n in found.tie if n != name), taken, held))
        last = _fitted(found)
        if last is not None:
            steps.append(_step("", (), last, held))
    except KeyboardInterrupt:
        return Improvement(tuple(steps), None, uses)
    return Improvement(tuple(steps), found, uses)


def _heard(runs: Runs, step: int) -> Runs:
    """The same runs, whose progress tells the step too."""
    return replace(runs, progress=lambda stage, done: runs.progress(f"step {step}: {stage}", done))


def _taken(found: Suggestion) -> Hypothesis | None:
    """What a verdict says to add; the model fitted again where that alone explains as much; None: stop."""
    if found.verdict not in ("effect", "tie") or not found.found:
        return None
    if found.before.refit and found.before.misfit <= MATERIAL * found.found[0].misfit:
        return found.before
    return found.found[0]


def _fitted(found: Suggestion) -> Hypothesis | None:
    """All free parameters fitted again, where that predicts clearly better and nothing else is wrong."""
    if found.verdict in ("input_error", "nothing_in_catalogue") or not found.before.refit:
        return None
    return found.before if found.before.misfit < MATERIAL * found.as_given.misfit else None


def _step(added: str, tie: tuple[str, ...], h: Hypothesis, held_out: Trials) -> ImprovedModel:
    model = h.known()
    held = open_loop_error(model, held_out) if len(held_out) else None
    return ImprovedModel(added, tie, model, h.judged.error, held)
