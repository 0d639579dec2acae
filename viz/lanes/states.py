"""What is so at each tick: whether it drives, what the estimate rests on, and what becomes of each channel.

A lane changes only when the new state has lasted, and then from when it began: one that alternates with each tick would
be told as a number of states. What comes once a stroke is there until it is missing for longer than that.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from estimator.faults.fault import Fault
from estimator.inputs.phase import turns
from estimator.record import Array, Sample
from estimator.rig import Rig
from estimator.step import Mode, Step, Track
from viz.drawing import paths

LASTS_S = 10.0
HOLD_S = 30.0  # without a reading, from which on a channel counts as silent: slow strokes take ten
SETTLED_S = LASTS_S + HOLD_S + 5.0
USED, SUSPECT, MUTED, SILENT, REFUSED = 0, 1, 2, 3, 10  # of a channel; with its Fault added where it was refused
MOTION = ("at rest", "driving", "speed unknown")
UNREAD = ": no displacement read"
MODES = {
    Mode.INIT: "init: no estimate yet",
    Mode.PREDICT: f"predict{UNREAD}",
    Mode.UPDATE: "update: displacement read",
    Mode.COASTING: "coasting: too few thermometers",
    Mode.INVALID: "invalid",
}
FIRST = 2  # lanes before those of the channels: motion and mode


def telling(track: Track, omega: Array) -> Array:
    """Ticks of a track after which a lane may be another, (n,): those near a change, the last before it among them.

    omega  (K,) rad/s;  all is settled LASTS_S + HOLD_S after a last change
    """
    drive, channels = (turns(omega), np.isnan(omega)), (track.may_drift_K != 0, np.isfinite(track.measured))
    so = np.column_stack([*drive, track.mode, track.begins, track.fused, track.fault, *channels])
    changes = np.flatnonzero((so[1:] != so[:-1]).any(axis=1)) + 1
    last_s = track.time_s[np.concatenate([[0], changes])][np.searchsorted(changes, np.arange(len(so)), "right")]
    told = track.time_s - last_s <= SETTLED_S
    told[changes - 1] = told[-1] = True
    return np.flatnonzero(told)


class State(NamedTuple):
    """What a lane says from a time on, s."""

    lane: str
    text: str
    since_s: float


class States:
    """The lanes of one rig, a tick at a time."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._lanes = (paths.DRIVE, paths.MODE, *(f"{paths.CHANNELS}/{paths.root(name)}" for name in rig.names))
        self._begin()

    def _begin(self) -> None:
        n, m = len(self._lanes), len(self._rig.names)
        self._now_s = self._update_s = -np.inf
        self._read_s, self._code = np.full(m, np.nan), np.full(m, SILENT)
        self._settled, self._next, self._since_s = np.full(n, -1), np.full(n, -1), np.full(n, np.nan)
        self._used = -1

    def tick(self, sample: Sample, step: Step) -> Iterator[State]:
        """What has changed, once it has lasted."""
        if step.time_s < self._now_s:
            self._begin()
        self._now_s = step.time_s
        self._read_s = np.where(np.isnan(self._read_s), step.time_s, self._read_s)
        motion = 2 if np.isnan(sample.omega) else int(turns(sample.omega))
        (mode, mode_s), (codes, codes_s) = self._mode(step), self._channels(step)
        now, since_s = np.array([motion, mode, *codes]), np.array([step.time_s, mode_s, *codes_s])
        other = now != self._next
        self._next, self._since_s = now, np.where(other, since_s, self._since_s)
        return self._told((now != self._settled) & (step.time_s - self._since_s >= LASTS_S))

    def end(self) -> Iterator[State]:
        """What had begun when the run ended."""
        return self._told(self._next != self._settled)

    def again(self) -> Iterator[State]:
        """All that is so now."""
        self._used = -1
        return self._told(self._settled >= 0, self._now_s)

    def _told(self, which: Array, since_s: float | None = None) -> Iterator[State]:
        """States of some lanes, and how many thermometers are used if that is another number now."""
        for i in np.flatnonzero(which).tolist():
            self._settled[i] = self._next[i] if since_s is None else self._settled[i]
            if self._lanes[i] == paths.DRIVE and not self._rig.moves:
                continue
            yield State(self._lanes[i], self._text(i), float(self._since_s[i]) if since_s is None else since_s)
        heat = self._settled[FIRST:][self._rig.is_thermometer]
        used = int(((heat == USED) | (heat == SUSPECT)).sum())
        if used != self._used and (heat >= 0).any():
            self._used = used
            since = float(self._since_s[FIRST:][self._rig.is_thermometer].max()) if since_s is None else since_s
            yield State(paths.THERMOMETERS, f"{used} of {len(heat)} used", since)

    def _text(self, i: int) -> str:
        code = int(self._settled[i])
        if i < FIRST:
            mode = MODES[Mode(code)] if self._rig.lengths else MODES[Mode(code)].removesuffix(UNREAD)
            return MOTION[code] if i == 0 else mode
        if code == SILENT:
            return "silent" if self._rig.is_thermometer[i - FIRST] else "not read"
        words = {USED: "used", SUSPECT: "suspect: may drift", MUTED: "muted"}
        return words.get(code) or f"refused: {Fault(code - REFUSED).why}"

    def _mode(self, step: Step) -> tuple[int, float]:
        """The mode, and since when; readings of the stroke centre come and go."""
        if step.mode == Mode.UPDATE:
            self._update_s = step.time_s
        if step.mode != Mode.PREDICT:
            return int(step.mode), step.time_s
        held = step.time_s - self._update_s <= HOLD_S
        return int(Mode.UPDATE if held else Mode.PREDICT), step.time_s if held else max(self._update_s, 0.0)

    def _channels(self, step: Step) -> tuple[Array, Array]:
        """What becomes of each channel, and since when, (m,) each; one that is only judged is as it was."""
        read = np.isfinite(step.measured)
        code = np.where(step.fused, np.where(step.may_drift_K != 0, SUSPECT, USED), MUTED)
        code = np.where(~step.fused & (step.fault > Fault.JUDGED), REFUSED + step.fault, code)
        taken = read & (step.fused | (step.fault != Fault.JUDGED))
        self._code, self._read_s = np.where(taken, code, self._code), np.where(read, step.time_s, self._read_s)
        gone = step.time_s - self._read_s > HOLD_S
        return np.where(gone, SILENT, self._code), np.where(gone, self._read_s, step.time_s)
