"""The search for a missing effect: which effects are tried, and what is looked at when it has ended."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ballscrew.own_effect.named import Named, named_effects
from ballscrew.workspace import Workspace
from estimator.accuracy.horizon import open_loop_error
from estimator.accuracy.noise_floor import Error
from estimator.batch.trials import trials_of
from estimator.effects import CATALOGUE
from estimator.faults.use import Use
from estimator.hypotheses.candidates import unfit
from estimator.missing_effect.suggestion import Suggestion
from estimator.model import file_and_class
from estimator.next_run.next_run import NextRun, next_run
from estimator.work import Runs


@dataclass(frozen=True)
class Verdict:
    """A suggestion with what it says of recordings held out, and of a run to make.

    held_out  open-loop error of the model as given, fitted again, then of all `found`; empty without such recordings
    uses      what was used of each recording, those held out too
    composed_held_out  of the model with the composed effect
    """

    suggestion: Suggestion
    held_out: Sequence[Error]
    next_run: NextRun | None
    uses: Sequence[Use]
    composed_held_out: Error | None = None


def effects_to_try(work: Workspace, own: Sequence[str]) -> list[Named]:
    """The catalogue, effects of one's own, and those beside the ones that the model uses.

    Says which of one's own cannot be tried on this rig, and why.
    """
    model = work.model
    files = [str((model.folder or Path()) / file_and_class(use)[0]) for use in model.use.values()]
    mine = {one.effect.name: one for word in dict.fromkeys([*files, *own]) for one in named_effects(word)}
    for one in mine.values():
        if one.file and one.effect.name not in model.effects and (why := unfit(model, work.rig, one.effect)):
            work.terminal.warn(f"{one.use} is not tried: {why}")
    return [*(Named(effect) for name, effect in CATALOGUE.items() if name not in mine), *mine.values()]


def verdict_of(suggestion: Suggestion, runs: Runs, held_out: Runs) -> Verdict:
    """What was found, with the run that settles what is open and the recordings held out."""
    runs.progress("looking for the run to make next", 0.95)
    run = next_run(suggestion.others, suggestion.kept(runs))
    held = trials_of(suggestion.as_given.model, held_out)
    listed = (suggestion.as_given, suggestion.again, *suggestion.found) if len(held) else ()
    errors = [open_loop_error(h.model, held) for h in listed]
    made = suggestion.composed
    composed = open_loop_error(made.hypothesis.model, held) if made is not None and len(held) else None
    return Verdict(suggestion, errors, run, suggestion.uses + held.uses, composed)
