"""What began within one recording, and how well a model explains all of them without it."""

from dataclasses import dataclass

from estimator.batch.trials import Trials, beside, slow_trial
from estimator.events.event import EXCHANGED, GROWING, Event
from estimator.events.events import events_of
from estimator.events.taken_out import taken_out
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.moments import moments_of
from estimator.hypotheses.panel import Explanation, Panel
from estimator.hypotheses.slopes import Column
from estimator.work import Runs

LEAST_GAIN = 20.0  # twice the log-likelihood of an event that is tried; the recording without it tells if it counts


@dataclass(frozen=True)
class Begun:
    """Events of one recording, and what a model leaves of all recordings without them."""

    events: tuple[Event, ...]
    judged: Explanation


def begun(ground: Ground, runs: Runs, trials: Trials, odd: int) -> Begun | None:
    """What began in the odd run beside what the model says; None where nothing did."""
    recording, model = runs.recordings[odd], ground.model
    told = events_of(model, trials, runs, LEAST_GAIN)
    found = tuple(event for event in told if event.run == recording.name and _moves(event))
    if not found:
        return None
    without = beside(trials[odd], slow_trial(model, runs.rig, taken_out(recording, trials[odd], model, found)))
    columns, known = [Column(model, path) for path in ground.paths], ground.belief(model, ground.paths)
    sums = [moments_of(without if i == odd else trial, model, columns) for i, trial in enumerate(trials)]
    return Begun(found, Panel(columns, sums, known).judge())


def _moves(event: Event) -> bool:
    """Whether an event is one whose part in the readings is known: an onset."""
    return event.gain > 0 and event.kind not in (EXCHANGED, GROWING)
