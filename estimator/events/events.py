"""Events: what began within some recordings, at times that nobody has told.

One after the other in each recording: the most likely onset of anything is found, put into what is known, the pattern
of the model's misfit sized again without it, and the next is looked for.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from estimator.batch.trials import Trials, slow_trials_of
from estimator.events.event import LOOSE, Event
from estimator.events.growing import growing
from estimator.events.kinds import told
from estimator.events.onset import Onset, Solver, best_onset, steps, worth
from estimator.events.pattern import pattern, sized
from estimator.events.readings import exchanged, of_readings
from estimator.events.short import short_heats
from estimator.events.signature import Signature, as_read, signature
from estimator.missing_heat.causes import Averages
from estimator.model import Model
from estimator.rig import Rig
from estimator.work import Runs, Workers, one_thread

LEAST_GAIN = 50.0  # 43 was the most in 51 recordings of nine machines with nothing planted, all by machine 0's model
MOST = 3  # in one recording
APART_SD = 2.0  # standard deviations between times that are told apart
TOGETHER_S = 900.0  # what begins so soon after another belongs to it
FEWEST = 40  # averages, below which a recording tells no times


@one_thread
def events(model: Model, runs: Runs) -> list[Event]:
    """What began within some recordings."""
    return events_of(model, slow_trials_of(model, runs), runs)


def events_of(model: Model, trials: Trials, runs: Runs, least: float = LEAST_GAIN) -> list[Event]:
    """The same of recordings that have been made ready for open-loop runs: by recording, and then by time."""
    seen = [each for each in trials.each(lambda trial: signature(model, trial)) if len(each.y) >= FEWEST]
    short, rig = short_heats(model, trials, least), runs.rig
    stays = _found(seen, trials.workers, least) if seen else []
    found = short + [event for event in stays if not _beside(event, short)]
    reads = runs.each(lambda one: as_read(model, rig, one))
    by_name = {read.recording.name: read for read in reads}
    wrong = [event for use in trials.uses for event in of_readings(use, by_name[use.name])]
    pairs = [event for read in reads for event in exchanged(read)]
    plugs = {(pair.run, channel) for pair in pairs for channel in (pair.channel, pair.name)}
    loose = {str(event.channel) for event in (*found, *wrong) if event.kind == LOOSE}
    heard = [event for event in found if not _shown_by(event, loose, rig)] + wrong
    found = [event for event in heard if (event.run, event.channel) not in plugs] + pairs
    order = {trial.recording.name: i for i, trial in enumerate(trials)}
    return sorted(found, key=lambda event: (order[event.run], event.since_s))


def _beside(event: Event, short: Sequence[Event]) -> bool:
    """Whether something seems to begin with what comes and goes."""
    return any(each.run == event.run and abs(each.since_s - event.since_s) <= TOGETHER_S for each in short)


def _shown_by(event: Event, loose: Collection[str], rig: Rig) -> bool:
    """Whether heat seems to be where a thermometer has come loose in one of the recordings: it is no heat."""
    places = [rig.channels[channel].at_mm for channel in loose]
    from_mm, to_mm = event.from_mm, event.to_mm
    if from_mm is None or to_mm is None:
        return False
    return any(x is not None and from_mm <= x <= to_mm for x in places)


def _found(seen: Sequence[Signature], workers: Workers, least: float) -> list[Event]:
    """Onsets within recordings, and what grows from one to the next."""
    search = Search(seen, workers, least)
    grown = growing(seen, search.sizes)
    begun = [
        replace(told(one, each), phase=each.spans.phase(one.since_s))
        for each, some in zip(seen, search.onsets(), strict=True)
        for one in some
    ]
    return single(begun, len(seen)) + grown


def single(begun: Sequence[Event], recordings: int) -> list[Event]:
    """Without what begins in several recordings, in more than half of them, in the same way or as long after a start
    or a stop: so it is with the model.

    Such is heat that follows every stop, wherever a model makes up for it that has its heat in the wrong place; an
    event happens once.
    """

    def often(event: Event, like: Callable[[Event, Event], bool]) -> bool:
        count = len({other.run for other in begun if like(event, other)})
        return count >= 2 and count > recordings / 2

    return [event for event in begun if not (often(event, alike) or often(event, in_step))]


def alike(a: Event, b: Event) -> bool:
    """Whether two events are of one kind and sign; heat that is small and everywhere may seem to be anywhere."""
    if (a.kind, a.name, a.channel) != (b.kind, b.name, b.channel):
        return False
    sizes = [(event.heat_W or 0.0) + (event.share or 0.0) + (event.offset or 0.0) for event in (a, b)]
    return sizes[0] * sizes[1] > 0


def in_step(a: Event, b: Event) -> bool:
    """Whether two events began as long after a start, or a stop, as far as their times are known."""
    if a.phase is None or b.phase is None or a.phase[0] != b.phase[0]:
        return False
    return abs(a.phase[1] - b.phase[1]) <= APART_SD * float(np.hypot(a.sd_s, b.sd_s))


class Search:
    """Looks for onsets in some recordings together, which share a pattern; sizes: of its causes.

    least  twice the log-likelihood that an onset adds
    """

    def __init__(self, seen: Sequence[Signature], workers: Workers = map, least: float = LEAST_GAIN) -> None:
        self._seen, self._workers, self._least = seen, workers, least
        self._steps = [list(steps(each)) for each in seen]
        self._found: list[list[Onset]] = [[] for _ in seen]
        self.sizes = self._sized()

    def onsets(self) -> list[list[Onset]]:
        """Of each recording, as they are found."""
        for _ in range(MOST):
            new = list(self._workers(self._next, range(len(self._seen))))
            if not any(new):
                break
            for found, onset in zip(self._found, new, strict=True):
                found.extend([onset] if onset else [])
            self.sizes = self._sized()
        return [self._apart(i, found) for i, found in enumerate(self._found)]

    def _next(self, i: int) -> Onset | None:
        onset = best_onset(self._seen[i], self._measured(i), self.sizes, self._steps[i])
        return onset if onset is not None and onset.gain > self._least and worth(onset, self._seen[i]) else None

    def _apart(self, i: int, found: Sequence[Onset]) -> list[Onset]:
        """Those that began at other times, told anew by the pattern without them; what came with one belongs to it."""
        kept: list[Onset] = []
        for onset in found:
            if all(abs(onset.since_s - other.since_s) > TOGETHER_S for other in kept):
                kept.append(onset)
        return [self._again(i, onset, [other for other in kept if other is not onset]) for onset in kept]

    def _again(self, i: int, onset: Onset, others: Sequence[Onset]) -> Onset:
        measured = pattern(self._seen[i], [other.column for other in others])
        return replace(Solver(measured, self.sizes).onset(self._seen[i], onset.step), gain=onset.gain)

    def _measured(self, i: int) -> Averages:
        return pattern(self._seen[i], [onset.column for onset in self._found[i]])

    def _sized(self) -> dict[str, float]:
        """Sizes of the pattern, common to all recordings."""
        return sized([self._measured(i) for i in range(len(self._seen))], self._workers)
