"""Logs that are parts of one recording, one behind the other."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drivers.budget import Budget
from drivers.frames import Frames, Tally
from drivers.logs.logs import is_lab_csv, read_log
from estimator.errors import InputError

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Joined:
    """The frames of all parts, and which part each came from.

    paths   of the parts, in order
    starts  index of the first frame of each part
    """

    paths: list[Path]
    starts: list[int]
    frames: Frames

    def where(self, index: int) -> str:
        """Place of one frame as text: "second.log line 12"."""
        part = int(np.searchsorted(self.starts, index, side="right")) - 1
        return f"{self.paths[part].name} {self.frames.where(index)}"


def join(paths: Sequence[Path], tally: Tally, budget: Budget, progress: Progress | None = None) -> Joined:
    """All usable frames of these logs, each log behind the one whose first frame is older.

    A log of which nothing can be used is told to `tally`; if that is all of them, it is an InputError.
    """
    parts: list[tuple[Path, Frames]] = []
    for i, path in enumerate(paths):
        if is_lab_csv(path):
            raise InputError(f"{path}: a lab CSV cannot be joined; logs of CAN frames can")
        if why := budget.spent(sum(len(frames) for _, frames in parts), 0, late=False):
            tally.note(f"{path.name} and what follows is not read: {why}")
            break
        own = Tally()
        try:
            parts.append((path, read_log(path, own, budget, progress and _share(progress, i, len(paths)))))
        except InputError as error:
            tally.note(f"left out: {error}")
            continue
        tally.skipped.update(own.skipped)
        for sentence in own.notes:
            tally.note(f"{path.name}: {sentence}")
    if not parts:
        raise InputError("; ".join(tally.notes))
    parts.sort(key=lambda part: float(part[1].time[0]))
    starts = np.cumsum([0, *(len(frames) for _, frames in parts)])[:-1].tolist()
    return Joined([path for path, _ in parts], starts, Frames.joined([frames for _, frames in parts]))


def _share(progress: Progress, i: int, of: int) -> Progress:
    return lambda share: progress((i + share) / of)
