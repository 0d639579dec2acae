"""The drive condensed to ticks: mean speed, and where the nut was.

A stretch between two frames counts in the tick of the later one, so that a tick needs no frame from its future. On a
stretch the speed runs evenly from one value to the next, through zero where it turns, and the nut evenly from one
position to the next.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivers.frames import Array, Index, Tally
from estimator.rig import AT_REST, Rig
from estimator.screw import Screw

AT_ONCE = 256  # ticks, of which every sum over the cells takes half a megabyte: that stays close to the processor
SOME, TOLD = 3, 0.7  # stretches of a tick that tell of a motion; of them those over which the position has moved
SLIP_MM, SLIP = 5.0, 0.1  # least jump between two frames, beside the longest way near it, on which it may have stopped
QUICK_S = 0.11  # from one frame to the next: in that no axis makes a stroke
GOES_MM, HELD = 0.1, 0.1  # ways that count; share of them with no new position: it is told more seldom than the speed
_STANDS = 1e-3  # cells: a shorter way is a stand


class Drive(NamedTuple):
    """Of each tick, as in Recording: rows of rad/s, cells, a number, s, a number, mm, cells, a number."""

    omega: Array
    coverage: Array
    unevenness: Array
    apart_s: Array
    pace: Array
    slip_mm: Array
    stay: NDArray[np.float32]
    idle: Array


class DriveCondenser:
    """Carries the last position and speed from call to call, and holds them for `held_ticks` after a last frame."""

    def __init__(self, rig: Rig, tally: Tally, held_ticks: int) -> None:
        self.tick_s, self.held_ticks = rig.tick_s, held_ticks
        self.tally = tally
        self.turns = "speed" in rig.inputs
        self.screw = rig.screw
        self.nut = rig.nut if rig.screw and "position" in rig.inputs else None
        self._last = (-np.inf, np.nan, np.nan)  # s, mm, rad/s
        self._held = (0, 0)  # ways that the speed tells of, and those of them on which the position stood
        self._before = np.full((3, 2), np.nan)  # the two frames before that
        self._lead = self.screw.lead_mm / (2 * np.pi) if self.screw else np.nan
        self._row = -(1 << 40)

    def rows(self, now: Array, position: Array, speed: Array, row: Index, rows: int) -> Drive:
        """From frames in order.

        now    (n,) s       position  (n,) mm, NaN where unknown
        speed  (n,) rad/s   row       (n,) tick of each frame, rising
        """
        cover = np.zeros((rows, self.screw.cells if self.screw else 0))
        stay = cover.astype(np.float32)  # the mean of a minute is taken of it
        if not self.turns:
            none = np.full(rows, np.nan)
            return Drive(np.zeros(rows), cover, np.ones(rows), np.zeros(rows), none, none, stay, np.zeros(rows))
        columns = zip(self._last, (now, position, speed), strict=True)
        now, position, speed = (np.concatenate(([last], column)) for last, column in columns)
        row = np.concatenate(([self._row], row))
        latest = np.searchsorted(row, np.arange(rows), side="right") - 1
        silent = np.arange(rows) - row[latest] > self.held_ticks
        self.tally.skip("tick without drive", np.count_nonzero(silent))
        steps = np.diff(now)
        steps[steps > (self.held_ticks + 0.5) * self.tick_s] = np.inf  # nobody knows what was between
        joined, apart = np.flatnonzero(np.isfinite(steps)), np.full(rows, np.nan)
        np.fmax.at(apart, row[1:], steps)
        passed, into = steps[joined], row[joined + 1]
        turned = _mean_speed(speed[joined], speed[joined + 1]) * passed
        squared = _mean_square(speed[joined], speed[joined + 1]) * passed
        stood = np.where(turned > AT_REST * passed, 0.0, passed)
        time, angle, squares, still = (np.bincount(into, each, rows) for each in (passed, turned, squared, stood))
        idle = np.divide(still, time, out=np.zeros(rows), where=angle > 0.0)
        omega = np.divide(angle, time, out=np.abs(speed[latest]), where=time > 0)
        uneven = np.divide(squares * time, angle**2, out=np.ones(rows), where=angle > 0)
        pace = self._pace(position, speed, joined, (turned, passed), into, rows)
        slip_mm = self._slip(np.array([now, position, speed]), row, rows)
        if self.nut:
            weight = np.where(angle[into] > 0, turned, passed)
            cover = self._cover(position, joined, weight, into, latest)
            stay = self._cover(position, joined, passed, into, latest).astype(np.float32)
        omega[silent] = cover[silent] = stay[silent] = np.nan
        self._last, self._row = (float(now[-1]), float(position[-1]), float(speed[-1])), int(row[-1]) - rows
        return Drive(omega, cover, uneven, apart, pace, slip_mm, stay, idle)

    def _pace(
        self, position: Array, speed: Array, joined: Index, stretch: tuple[Array, Array], row: Index, rows: int
    ) -> Array:
        """How far the position moves as a share of what the speed says, where that does not turn, (rows,).

        Below 0 where it falls while the speed is positive; inf where it moves while the speed is 0, told so often that
        no stroke is missed; NaN where the position is told more seldom than the speed: then it may have turned between
        two. Of each `stretch` what turned, rad, and what passed, s.
        """
        moved, (turned, passed) = position[joined + 1] - position[joined], stretch
        read = np.isfinite(moved)
        known = read & (speed[joined] * speed[joined + 1] > 0)
        stands = (np.bincount(row[known], minlength=rows) == 0)[row]  # by the speed alone
        known |= read & stands & (speed[joined] == 0) & (speed[joined + 1] == 0) & (passed <= QUICK_S)
        sums = (np.abs(moved), moved * np.sign(speed[joined]), self._lead * turned)
        way, along, path = (np.bincount(row[known], amount[known], rows) for amount in sums)
        told, of = (np.bincount(row[some], minlength=rows) for some in (known & (moved != 0), known))
        sure = np.where(path > 0, told > TOLD * of, (told >= SOME) & (way > SLIP_MM)) & (of >= SOME)
        with np.errstate(divide="ignore"):
            return np.divide(np.copysign(way, along), path, out=np.full(rows, np.nan), where=sure)

    def _slip(self, frames: Array, row: Index, rows: int) -> Array:
        """By how much the position jumps from one frame to the next, beside what the speed says, (rows,) mm; 0: not.

        frames (3, n) s, mm, rad/s. A jump stands alone: on the ways before and after it position and speed agree. It
        counts in the tick of the frame after these; NaN where these are not known, or the position is told more seldom.
        """
        now, position, speed = frames = np.hstack([self._before, frames])
        self._before = frames[:, -3:-1]
        passed = np.where(np.diff(now) <= QUICK_S, np.diff(now), np.nan)
        moved, told = np.diff(position), self._lead * passed * (speed[1:] + speed[:-1]) / 2
        moved, told = (np.array([each[:-2], each[1:-1], each[2:]]) for each in (moved, told))  # before, there, after
        goes = np.abs(told[1]) > GOES_MM
        went, held = (np.cumsum(so) + n for so, n in zip((goes, goes & (moved[1] == 0)), self._held, strict=True))
        self._held = (went[-1], held[-1]) if len(went) else self._held
        row, known = row[1:], np.isfinite(moved + told).all(axis=0) & (held <= HELD * went)
        along = np.sign((moved * told)[::2].sum(axis=0))
        off = moved - np.where(along == 0, 1.0, along) * told
        most = SLIP_MM + (1.0 + SLIP) * np.abs(told).max(axis=0) + np.ptp(told, axis=0)
        jumps = known & ((np.abs(off) > most) == [[False], [True], [False]]).all(axis=0)
        found = np.bincount(row[jumps], off[1, jumps], rows).astype(float)
        found[np.bincount(row[known], minlength=rows) == 0] = np.nan
        return found

    def _cover(self, position: Array, joined: Index, weight: Array, row: Index, latest: Index) -> Array:
        """Cover of the cells by the nut, on its way between frames; where it has no way, where the latest one was."""
        assert self.screw
        assert self.nut
        rows, length_mm = len(latest), self.nut.length_mm
        centre = self.nut.centre(position)
        known = np.isfinite(centre[joined]) & np.isfinite(centre[joined + 1])
        way = centre[joined[known]], centre[joined[known] + 1]
        cover = covered(self.screw, length_mm, way, weight[known], row[known], rows)
        cover[np.bincount(row[known], minlength=rows) == 0] = np.nan
        still = np.bincount(row, weight, rows) == 0
        parked = centre[latest[still]]
        cover[still] = self.screw.overlap(parked - length_mm / 2, parked + length_mm / 2)
        return cover


def _mean_speed(begin: Array, end: Array) -> Array:
    """Mean of |speed| while it runs evenly from begin to end: (n,)."""
    size = np.abs(begin) + np.abs(end)
    turns = begin * end < 0
    return np.asarray(np.divide(begin**2 + end**2, 2 * size, out=size / 2, where=turns))


def _mean_square(begin: Array, end: Array) -> Array:
    """Mean of speed^2 while it runs evenly from begin to end: (n,)."""
    return np.asarray((begin**2 + begin * end + end**2) / 3)


def covered(screw: Screw, length_mm: float, way: tuple[Array, Array], weight: Array, row: Index, rows: int) -> Array:
    """Cover of each cell, (rows, cells), 0 ... 1: the weighted mean over the ways of a row; 0 in a row without weight.

    way     (N,), (N,)  nut centre at begin and end of each way, mm
    weight  (N,)        time or angle of each way
    row     (N,)        tick of each way, rising
    """
    found = np.empty((rows, screw.cells))
    for first in range(0, rows, AT_ONCE):
        last = min(first + AT_ONCE, rows)
        some = slice(*np.searchsorted(row, [first, last]))
        own = way[0][some], way[1][some]
        found[first:last] = _covered(screw, length_mm, own, weight[some], row[some] - first, last - first)
    return found


def _covered(screw: Screw, length_mm: float, way: tuple[Array, Array], weight: Array, row: Index, rows: int) -> Array:
    """The same for as many rows as memory has room for."""
    cell = screw.length * 1e3
    low = (np.minimum(*way) - screw.from_mm) / cell
    high = (np.maximum(*way) - screw.from_mm) / cell
    half = length_mm / 2 / cell
    total = np.bincount(row, weight, rows)
    share = np.divide(weight, total[row], out=np.zeros_like(weight), where=total[row] > 0)
    runs = high - low > _STANDS
    begin, end, slope = low[runs], high[runs], share[runs] / (high - low)[runs]
    stood, whole = (low + high)[~runs] / 2, share[~runs]
    at = np.concatenate([begin - half, end - half, begin + half, end + half, stood - half, stood + half])
    kink = np.concatenate([slope, -slope, -slope, slope, np.zeros(2 * len(whole))])
    jump = np.concatenate([np.zeros(4 * len(slope)), whole, -whole])
    return _means(at, kink, jump, np.concatenate([np.tile(row[runs], 4), np.tile(row[~runs], 2)]), (rows, screw.cells))


def _means(at: Array, kink: Array, jump: Array, row: Index, shape: tuple[int, int]) -> Array:
    """Mean in each cell, `shape` (rows, cells), of profiles whose slope changes by `kink` and height by `jump`.

    at, kink, jump, row  (N,) of each change: where, in cells; 1 per cell; 0 ... 1; of which profile
    """
    rows, bins = shape[0], shape[1] + 2  # one before the screw, one behind
    cell = np.clip(np.floor(at), -1, shape[1]).astype(np.intp) + 1
    where, rest = row * bins + cell, cell - at
    sums = (kink, jump - kink * at, (kink * rest / 2 + jump) * rest)
    slope, level, inside = (np.bincount(where, each, rows * bins).reshape(rows, bins) for each in sums)
    slope, level = (np.cumsum(each, axis=1)[:, :-2] for each in (slope, level))
    return np.clip(slope * (np.arange(shape[1]) + 0.5) + level + inside[:, 1:-1], 0.0, 1.0)
