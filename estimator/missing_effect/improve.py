"""Add what is missing, one effect at a time, until no effect helps any more.

Each step searches (`suggest`), adds what the verdict names, and begins again from that model; what earlier steps added
is fitted again with it, for it was found while the rest was missing. Of effects that these
recordings cannot tell apart the best is added, and its rivals are named. At the end all free parameters are fitted
again, where that predicts recordings left out better.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from estimator.accuracy.floor import Error
from estimator.accuracy.horizon import open_loop_only, overall
from estimator.batch.trial import trials_of
from estimator.effect import Effect
from estimator.missing_effect.hypothesis import Hypothesis, refined
from estimator.missing_effect.suggest import suggest
from estimator.missing_effect.suggestion import MATERIAL, Suggestion
from estimator.model import Model
from estimator.record import Recording
from estimator.rig import Rig
from estimator.work import Share

MOST = 6

Progress = Callable[[int, str, float], None]


@dataclass(frozen=True)
class Step:
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
    """All steps, from the model as given to the best, and the last verdict; None: stopped by Ctrl-C before it."""

    steps: tuple[Step, ...]
    last: Suggestion | None

    @property
    def model(self) -> Model:
        """The best model."""
        return self.steps[-1].model


def improve(
    model: Model, rig: Rig, recordings: Sequence[Recording], held_out: Sequence[Recording],
    effects: Sequence[type[Effect]], each: Progress = lambda step, stage, share: None, share: Share = map,
) -> Improvement:  # fmt: skip
    """Improve a model. `each` hears the step, the stage and the share of it done. Ctrl-C keeps the best so far."""
    first = refined(model, trials_of(model, rig, recordings), [], False, {}, share)
    steps = [_step("", (), first, rig, held_out)]
    try:
        while True:
            heard, added = partial(each, len(steps)), [step.added for step in steps]
            found = suggest(steps[-1].model, rig, recordings, effects, heard, share, added)
            taken = _taken(found) if len(steps) <= MOST else None
            if taken is None:
                break
            name = taken.names[0] if taken.names else ""
            steps.append(_step(name, tuple(n for n in found.tie if n != name), taken, rig, held_out))
        last = _fitted(found)
        if last is not None:
            steps.append(_step("", (), last, rig, held_out))
    except KeyboardInterrupt:
        return Improvement(tuple(steps), None)
    return Improvement(tuple(steps), found)


def with_sd(h: Hypothesis) -> Model:
    """The model of a hypothesis, with the sd of what was fitted."""
    return h.model.with_values(dict(h.parameters()))


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


def _step(added: str, tie: tuple[str, ...], h: Hypothesis, rig: Rig, held_out: Sequence[Recording]) -> Step:
    model, held = with_sd(h), None
    if held_out:
        found = [open_loop_only(trial, model) for trial in trials_of(model, rig, held_out)]
        held = overall(found, "open_loop")
    return Step(added, tie, model, Error(h.judged.heat_K, h.judged.length_um), held)
