"""What is asked of a review on the command line, and what comes of it: for every command that reviews recordings."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial, wraps
from typing import Any

import click

from ballscrew.completion import mutes, words
from ballscrew.machine import MachineVerdict
from ballscrew.muting import chosen_thermometers, muted
from ballscrew.options import channel_options, join_option, stacked
from ballscrew.workers.processes import working
from ballscrew.workspace import Loaded, Workspace
from estimator.accuracy.machine import Match
from estimator.accuracy.review import Review, review
from estimator.errors import InputError
from estimator.record import Recording
from estimator.work import kept

Places = Callable[[Recording], Sequence[float]]  # positions of the table at which a recording's error is to be told

Posed = Callable[..., Review]  # of `each`, who hears how many ticks are done


@dataclass(frozen=True)
class Reviewed:
    """Reviews, what each is of, which of them the model was fitted to, and the seconds that each took.

    without  what the filter was not to use, in words
    failed   what could not be read or used, a sentence each
    """

    loaded: Sequence[Loaded]
    reviews: Sequence[Review]
    fitted: Sequence[bool]
    seconds: Sequence[float]
    verdict: MachineVerdict
    without: Sequence[str]
    failed: Sequence[str]


@dataclass(frozen=True)
class Asked:
    """How recordings are to be read, and what the filter is not to use."""

    join: bool
    channels: str | None
    no_displacement: bool
    spans: tuple[str, ...]

    def reviewed(self, work: Workspace, places: Places = lambda _: (), workers: int | str = 1) -> Reviewed | None:
        """Read and review the logs; None where none could be used."""
        names = chosen_thermometers(self.channels, work.rig)
        work.read(join=self.join)
        work.terminal.say_if_compiling("passes", "smoothed")
        judged = list(_used(work, [self._posed(work, one, names, places) for one in work.loaded], workers))
        if not judged:
            return None
        loaded, reviews, seconds = zip(*judged, strict=True)
        known = set(work.model.about.get("fitted_on", {}).values())
        fitted = [r.recording.fingerprint in known for r in reviews]
        verdict = MachineVerdict(work, work.model, Match([r.off_sd for r in reviews]), loaded)
        return Reviewed(loaded, reviews, fitted, seconds, verdict, self.without, work.failed)

    @property
    def without(self) -> list[str]:
        """What the filter is not to use, in words."""
        others = [f"thermometers other than {self.channels}"] if self.channels is not None else []
        return [*others, *(["displacement"] if self.no_displacement else []), *self.spans]

    def _posed(self, work: Workspace, one: Loaded, names: list[str] | None, places: Places) -> Posed:
        """The review of a recording, still to be done."""
        recording = one.recording
        mute = muted(recording, work.rig, names, self.no_displacement, self.spans)
        given = recording, work.rig, work.model, work.truth_of(one), mute, names
        return partial(review, *given, table_mm=places(recording))


def _used(work: Workspace, posed: Sequence[Posed], workers: int | str) -> Iterator[tuple[Loaded, Review, float]]:
    """Each recording that can be used, its review, and the seconds that it took."""
    for one, found in zip(work.loaded, _judged(work, posed, workers), strict=True):
        if isinstance(found, InputError):
            work.fail(found)
        else:
            yield one, *found


def _judged(work: Workspace, posed: Sequence[Posed], workers: int | str) -> Iterator[tuple[Review, float] | InputError]:
    """What came of each, one after the other with a bar for each, or of all, shared."""
    if workers != 1:
        with work.terminal.progress(f"reviewing {len(posed)} recordings", None), working(workers) as shared:
            yield from kept(shared)(_timed, posed)
        return
    for one, recording in zip(posed, work.recordings, strict=True):
        with work.terminal.progress(recording.name, len(recording)) as update:
            yield _timed(partial(one, each=update))


def _timed(posed: Posed) -> tuple[Review, float] | InputError:
    """A review and the seconds that it took, or why there is none."""
    began = time.perf_counter()
    try:
        return posed(), time.perf_counter() - began
    except InputError as error:
        return error


def review_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """--join, --channels, --no-displacement and --mute on a command, which gets them as `asked`."""

    @wraps(command)
    def with_asked(
        *passed: Any, join: bool, channels: str | None, no_displacement: bool, spans: tuple[str, ...], **given: Any
    ) -> Any:
        return command(*passed, asked=Asked(join, channels, no_displacement, spans), **given)

    return stacked(
        join_option,
        channel_options,
        click.option(
            "--mute", "spans", multiple=True, metavar="NAME:FROM[-TO|+TIME]", shell_complete=words(mutes),
            help="Do not use a channel, `telemeter` or `displacement` from FROM, s from the start or stop1 ..., to TO, "
            "or for TIME, like 60min",
        ),
    )(with_asked)  # fmt: skip
