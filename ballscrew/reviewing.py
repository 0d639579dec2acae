"""What is asked of a review on the command line, and what comes of it: for every command that reviews recordings."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import wraps
from typing import Any

import click

from ballscrew.completion import mutes, words
from ballscrew.machine import MachineVerdict
from ballscrew.muting import chosen_thermometers, muted
from ballscrew.options import channel_options, join_option, stacked
from ballscrew.workspace import Loaded, Workspace
from estimator.accuracy.machine import Match
from estimator.accuracy.review import Review, review
from estimator.errors import InputError
from estimator.record import Recording

Places = Callable[[Recording], Sequence[float]]  # positions of the table at which a recording's error is to be told


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

    def reviewed(self, work: Workspace, places: Places = lambda _: ()) -> Reviewed | None:
        """Read and review the logs; None where none could be used."""
        names = chosen_thermometers(self.channels, work.rig)
        work.read(join=self.join)
        work.terminal.say_if_compiling("passes", "smoothed")
        judged = list(self._judged(work, names, places))
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

    def _judged(
        self, work: Workspace, names: list[str] | None, places: Places
    ) -> Iterator[tuple[Loaded, Review, float]]:
        """Each recording that can be used, its review, and the seconds that it took."""
        for one in work.loaded:
            began, recording = time.perf_counter(), one.recording
            mute, truth = muted(recording, work.rig, names, self.no_displacement, self.spans), work.truth_of(one)
            at_mm = places(recording)
            try:
                with work.terminal.progress(recording.name, len(recording)) as update:
                    found = review(recording, work.rig, work.model, truth, mute, names, update, at_mm)
            except InputError as error:
                work.fail(error)
                continue
            yield one, found, time.perf_counter() - began


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
