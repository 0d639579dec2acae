"""Every doubt about a rig folder beside its recordings."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ballscrew.doubts import signals
from ballscrew.doubts.doubt import Case, Doubt
from ballscrew.doubts.drive import drive
from ballscrew.doubts.growth import growth
from ballscrew.doubts.guesses import guesses
from ballscrew.doubts.order import order
from ballscrew.new_rig.bus_log import bus_log_of
from ballscrew.new_rig.lab_table import is_lab_table, read_lab_table
from drivers.budget import Budget
from drivers.decode.dbc import find_dbc
from drivers.frames import Tally
from drivers.logs.logs import read_log
from drivers.recordings import read_recording, recording_of
from estimator.model import Model
from estimator.rig import Rig

PLACES_GUESSED = "guessed: its place"
ABOUT = (
    signals.never_came, signals.units, signals.outside, signals.constant, signals.ticks, signals.not_measured, drive,
    growth, order, signals.unnamed, signals.noted,
)  # fmt: skip


@dataclass
class Told:
    """A doubt, and in which recordings it is."""

    doubt: Doubt
    recordings: list[str] = field(default_factory=list)


def of_the_folder(rig: Rig) -> Iterator[Doubt]:
    """What can be said without a recording: guesses that `ballscrew init` made and nobody has looked at."""
    if at := guesses(rig.folder):
        what = f"{len(at)} lines are guesses of `ballscrew init`, the first in line {at[0]}"
        yield Doubt("rig.toml", what, "look at each, and take its mark away")
    if not (rig.folder / "model.toml").is_file():
        yield Doubt("model.toml", "is not there", "write one, or name another with --model at each command")


def of_recording(path: Path, rig: Rig, model: Model) -> Iterator[Doubt]:
    """What is in doubt beside a recording; one that cannot be used is an InputError."""
    if is_lab_table(path):
        case = Case(rig, model, read_recording(path, rig), read_lab_table(path, Tally(), rig.log.csv))
    else:
        tally, budget = Tally(), Budget()
        frames = read_log(path, tally, budget)
        dbc = find_dbc(rig.log.dbc, rig.folder)
        recording = recording_of(path, frames, rig, tally, budget)
        case = Case(rig, model, recording, bus_log_of(path, frames, dbc, Tally(), rig.log.bus))
    guessed = PLACES_GUESSED in (rig.folder / "rig.toml").read_text(encoding="utf-8-sig")
    for about in ABOUT:
        if not (guessed and about is order):
            yield from about(case)


def together(found: Iterable[tuple[str, Doubt]]) -> Sequence[Told]:
    """Those of several recordings as one, by place and fix: with what the first of them says."""
    told: dict[tuple[str, str], Told] = {}
    for name, doubt in found:
        one = told.setdefault((doubt.place, doubt.fix), Told(doubt))
        if name and name not in one.recordings:
            one.recordings.append(name)
    return [*told.values()]
