"""ballscrew export: convert logs of CAN frames to another format."""

import heapq
import math
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import repeat
from pathlib import Path
from typing import Any

import click

from ballscrew.options import logs_argument, output_file, terminal_options, writable
from ballscrew.terminal import Terminal, duration
from drivers.frames import Tally
from drivers.logs.every_frame import every_frame
from drivers.logs.log_writer import LogWriter, check_format
from drivers.received import Received
from drivers.recordings import find_recordings
from estimator.errors import InputError, SetupError

# of an id from one log to another: parts of a recording overlap by a few frames where a clock was set
_MOST_RETURNS = 3


@dataclass
class Source:
    """One log to convert: how far it is read, how many frames it gave, and what was none."""

    path: Path
    tally: Tally = field(default_factory=Tally)
    frames: int = 0
    read: int = 0  # bytes

    def __iter__(self) -> Iterator[Received]:
        for frame in every_frame(self.path, self.tally, self._at):
            self.frames += 1
            yield frame

    def _at(self, byte: int) -> None:
        self.read = byte


@click.command("export")
@logs_argument
@output_file(
    "-o", "out", metavar="FILE", required=True, callback=writable,
    help="Log to write; its suffix says the format: .blf, .mf4, .asc, .trc or .log.",
)  # fmt: skip
@terminal_options
def command(terminal: Terminal, logs: tuple[Path, ...], out: Path) -> int:
    """Convert each LOG, or several to one in the order of their times.

    All frames go over, remote, error and FD frames too, with their time on the clock to the microsecond. Two formats
    hold less: .asc keeps local time without a zone, and of an error frame only that there was one; .trc keeps data
    frames only, and what it cannot hold is counted. A folder means all logs in it.
    """
    check_format(out)
    sources = [Source(path) for path in find_recordings(logs)]
    if not sources:
        raise InputError(f"{', '.join(map(str, logs))}: no logs in there")
    if out.resolve() in [source.path.resolve() for source in sources]:
        raise SetupError(f"{out}: is one of the logs to convert; name another file with -o")
    began = time.perf_counter()
    try:
        told = _convert(terminal, sources, out)
    except OSError as error:
        raise SetupError(f"{out}: cannot be written: {(error.strerror or str(error)).lower()}") from error
    told |= {"took_s": time.perf_counter() - began, "bytes": out.stat().st_size}
    _print(terminal, sources, out, told)
    terminal.json(told)
    return 0 if all(source.frames for source in sources) else InputError.exit_code


def _convert(terminal: Terminal, sources: Sequence[Source], out: Path) -> dict[str, Any]:
    """Write all frames of the sources into `out`; what there is to say about it."""
    first_s, last_s = math.inf, 0.0
    size = sum(source.path.stat().st_size for source in sources if source.path.is_file())
    with terminal.progress(out.name, size) as update, LogWriter(out) as writer:
        for number, frame in enumerate(_merged(sources)):
            first_s, last_s = min(first_s, frame.time_s), max(last_s, frame.time_s)
            writer.write(frame)
            if number % 5000 == 0:
                update(sum(source.read for source in sources), f"{number} frames")
        if not writer.frames:
            why = "; ".join(f"{source.path}: {_unused(source)}" for source in sources)
            raise InputError(f"{out}: not written, no frames ({why})")
    return {
        "path": str(out),
        "frames_in": sum(source.frames for source in sources),
        "frames_out": writer.frames,
        "left_out": dict(writer.left_out),
        "early": writer.early,
        "seconds": last_s - first_s,
        "logs": [
            {"path": str(one.path), "frames": one.frames, "skipped": one.tally.counts(), "notes": one.tally.notes}
            for one in sources
        ],
    }


def _merged(sources: Sequence[Source]) -> Iterator[Received]:
    """All frames in the order of their times; logs that go on with each other's ids side by side are two recordings."""
    latest: dict[tuple[str, int, bool], tuple[int, Received]] = {}
    returns: Counter[tuple[str, int, bool]] = Counter()
    numbered = [zip(source, repeat(k)) for k, source in enumerate(sources)]
    for frame, k in heapq.merge(*numbered, key=lambda one: one[0].time_s):
        key = frame.channel, frame.id, frame.extended
        before, last = latest.get(key, (k, None))
        if before != k and last == frame:  # parts of one recording overlap
            sources[k].tally.skip("frame that the log before has too")
            continue
        latest[key] = k, frame
        returns[key] += before != k
        if returns[key] > _MOST_RETURNS * len(sources):
            raise InputError(
                f"{sources[before].path.name} and {sources[k].path.name} both have 0x{frame.id:X} on {frame.channel} "
                "at the same times: two recordings whose clocks overlap; export each to a file of its own"
            )
        yield frame


def _print(terminal: Terminal, sources: Sequence[Source], out: Path, told: Mapping[str, Any]) -> None:
    terminal.say(
        f"{out}: {told['frames_in']} frames in, {told['frames_out']} out, {duration(told['seconds'])}, "
        f"{told['bytes'] / 1e6:.1f} MB, written in {told['took_s']:.1f} s"
    )
    if told["left_out"]:
        kinds = ", ".join(f"{count} {kind}" for kind, count in told["left_out"].items())
        terminal.warn(f"{out}: {kinds} frames left out: {out.suffix} holds data frames only")
    if told["early"]:
        terminal.warn(f"{out}: {told['early']} frames are stamped before the first one and got its time")
    for source in sources:
        if not source.frames:
            terminal.error(f"{source.path}: {_unused(source)}")
        elif unused := _unused(source):
            terminal.warn(f"{source.path}: {unused}")


def _unused(source: Source) -> str:
    """What of a log was no frame, in words; empty if all was used."""
    counts = [f"{count} x {reason}" for reason, count in source.tally.counts().items()]
    nothing = [] if source.frames else ["no frame in it"]
    return "; ".join([*nothing, *counts, *source.tally.notes])
