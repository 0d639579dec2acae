"""The judge: which channels are fused at a tick, and which are broken, how, and since when.

A thermometer that leaves the model alone is held, and after ten seconds it is left out for a fault of its own; where
most leave together, the telemeter has other zeros, or the run began with what were no temperatures. Where most leave
and have not moved as far themselves, or went there step by step, the model has left them, and they are believed; so are
fewer than three, of which none is the others' witness. A length has no neighbours: where it jumps it has another zero,
and where it departs slowly the model is wrong, and it is believed, until it has led the estimate further from what
thermometers alone say than these and the model allow.
What is broken goes on being compared, and is taken back when it has been well for long enough. What only may drift is
said, and fused with a zero that is not known by as much: the estimate does not go along any further.
"""

from dataclasses import replace

import numpy as np

from estimator.faults.beside.neighbours import Neighbours
from estimator.faults.fault import Fault, Judgement, Seen, Tick
from estimator.faults.jumps import Deviations, Jumps
from estimator.faults.machine import SHARES, Known
from estimator.faults.recovery import Progress, Recovery
from estimator.faults.standstill import Standstill
from estimator.faults.suspects import STILL, STUCK, Suspects
from estimator.record import Array, held
from estimator.rig import Rig

TOGETHER_TICKS = 5  # that most thermometers have to be beyond their limits together
FEWEST = 3  # thermometers, of which one can have left the others
STAYED = 0.5  # of how far a reading is from the model: it has changed by less, and the model by more
AT_ONCE = 0.7  # of it at the first tick: another zero is there from one tick to the next
START_S = 60.0  # within which all that has been known of a run may have been wrong
LENGTH_READINGS = 3  # of a length beyond its limit, until it has another zero
SILENT_TICKS = 3  # after which a level has to be learnt again
SILENT_LENGTH_S = 120.0


class Judge:
    """What is known of the channels of one run.

    fault, since_s  (m,) as of the last tick: a Fault each, and since when, NaN: it is well
    """

    def __init__(self, rig: Rig, noise: Array, begun_s: float, begun_with: Array, known: Known) -> None:
        """noise (m,) sd of each reading, inf: no model; the run began with some of the channels (m,), first at begun_s.

        known  how well the model's parameters are
        """
        m, self._heat, self._begun_s, self._begun_with = len(noise), rig.is_thermometer, begun_s, begun_with
        self._modelled = np.isfinite(noise)
        self._jumps, self._standstill = Jumps(noise, self._heat, rig.tick_s, rig.x_mm), Standstill(self._heat)
        self._neighbours = Neighbours(rig, noise, known)
        self._suspects = Suspects(m, begun_with)
        self.fault, self.since_s = np.zeros(m, dtype=np.int8), np.full(m, np.nan)
        self._silent_ticks = np.where(self._heat, SILENT_TICKS, max(SILENT_TICKS, SILENT_LENGTH_S / rig.tick_s))
        self._recovery = Recovery(self._silent_ticks * rig.tick_s)
        self._silent, self._beyond, self._at_once, self._held, self._loose_K = np.zeros((5, m))
        self._together = 0
        self._rezeroed, self._usual = np.zeros(m, dtype=bool), np.full(m, np.nan)

    @property
    def well(self) -> Array:
        """Which channels are fused at the next tick unless something happens, (m,) bool."""
        return np.asarray(self.fault == Fault.NONE)

    @property
    def _said_since_s(self) -> Array:
        """Since when channels are broken or, where they are not, suspected, (m,) s."""
        return np.where(self.fault == Fault.NONE, self._neighbours.since_s, self.since_s)

    def judge(self, seen: Seen) -> Judgement:
        """The first of some ticks: all, or up to the first in which something happens.

        In the ticks before that one the channels that are `well` are fused, as whoever asks has taken for granted.
        """
        value = np.where(seen.muted | ~np.isfinite(seen.sd), np.nan, seen.value)
        seen = replace(seen, value=value, astray=seen.astray | self._neighbours.elsewhere)
        repeats = self._standstill.compare(np.where(np.isfinite(seen.value), seen.reading, np.nan))
        jumps = self._jumps.compare(seen, self.well, self._neighbours.warm, repeats.resolution)
        progress = self._recovery.compare(seen.time_s, jumps, repeats.count, self.fault)
        ticks = self._quiet(seen, jumps, repeats.count, progress)
        used = self.well & np.isfinite(seen.value) & ~jumps.beyond
        neighbours = self._neighbours
        before = self.fault.copy(), self._said_since_s, neighbours.may_drift_K.copy()
        added = neighbours.add(seen.first(ticks), used[:ticks])
        ticks, drifting = added.ticks, added.drifting
        fault, since_s, may_drift_K = (np.tile(each, (ticks, 1)) for each in before)
        last = ticks - 1
        if last:
            self._jumps.learn(jumps, last, self.well)
        read = np.isfinite(seen.value[last])
        self._usual = held(np.where(self.well, seen.reading[:last], np.nan), self._usual)[-1]
        moved = np.abs(seen.reading - self._usual)
        of_last = (a[last] for a in (jumps.value, jumps.limit, jumps.beyond, repeats.count, moved))
        tick = Tick(float(seen.time_s[last]), read, self._jumps.known, *of_last)
        self._recovery.learn(progress, ticks)
        jump, anew = self._decide(tick, progress.back[last])
        drift = None
        if drifting is not None and self.fault[drifting] == Fault.NONE:
            self._set(drifting, Fault.DRIFTING, tick)
            drift = np.where(np.arange(len(read)) == drifting, self._neighbours.departed_K, 0.0)
        apart = added.apart and self._leave_lengths(tick)
        self._usual = held(np.where(self.well, seen.reading[last:ticks], np.nan), self._usual)[-1]
        self._jumps.learn(jumps, ticks, self.well)
        self._standstill.learn(repeats, ticks)
        self._begun_with = self._begun_with & ~self._jumps.known
        self._silent = self._silence(seen.value)[last]
        self._forget(jump)
        if drift is not None or apart:
            self._jumps.forget(self._heat)  # the estimate goes back to where it would be without
        fault[last], since_s[last], may_drift_K[last] = self.fault, self._said_since_s, neighbours.may_drift_K
        if jump is not None:
            fault[last][jump != 0.0] = Fault.JUDGED  # its zero is another one from the next tick on
        heated = self._heated()
        return Judgement(
            fault, since_s, may_drift_K, added.lacks_K, added.departs_K, added.off_share, added.shift_mm, jump,
            drift, heated, self._loosen(added.off_share[-1]), apart, anew,
        )  # fmt: skip

    def _leave_lengths(self, tick: Tick) -> bool:
        """Lengths are broken that have led the estimate too far; whether there are any that were not yet."""
        which = self._modelled & ~self._heat & (self.fault <= Fault.JUDGED)
        for i in np.flatnonzero(which).tolist():
            self._set(i, Fault.APART, tick)
        return bool(which.any())

    def _loosen(self, share: float) -> Array | None:
        """By how much more channels may have drifted than was said of them before, (m,).

        None where the model is off by more than the least share: then what it misses is as likely heat, which only
        readings tell of
        """
        own = (self.fault == Fault.NONE) & (share < SHARES[2])
        may_K = np.where(own, np.abs(self._neighbours.may_drift_K), 0.0)
        more = np.sqrt(np.maximum(may_K**2 - self._loose_K**2, 0.0))
        self._loose_K = np.where(may_K > 0.0, np.maximum(may_K, self._loose_K), 0.0)
        if more.any():
            self._jumps.forget(more > 0.0)  # its zero takes over what it has been off by: no jump
            return more
        return None

    def _heated(self) -> Array | None:
        """Thermometers, (m,) bool, whose zeros were loosened and are what they were: they only read heat."""
        heated = self._neighbours.heated & (self._loose_K > 0.0) & ~self._rezeroed
        if not heated.any():
            return None
        self._jumps.forget(heated)
        return heated

    def by_another_model(self, known: Known) -> None:
        """Go on with what another model says of the readings, of which other parameters are known."""
        self._neighbours.forget_all(known)

    def _quiet(self, seen: Seen, jumps: Deviations, repeats: Array, progress: Progress) -> int:
        """How many ticks there are up to the first in which something happens; one while a channel is being judged."""
        if (self.fault == Fault.JUDGED).any():
            return 1
        silent = (jumps.count > 0) & (self._silence(seen.value) >= self._silent_ticks)
        wrong = jumps.beyond | (repeats >= STILL) | silent
        event = np.where(self.well, wrong, progress.back | self._stands(repeats)).any(axis=1)
        return int(np.argmax(event)) + 1 if event.any() else event.size

    def _stands(self, repeats: Array) -> Array:
        """Thermometers (..., m) that jumped to where they stand still."""
        return (self.fault == Fault.JUMPED) & (repeats >= STUCK)

    def _decide(self, tick: Tick, back: Array) -> tuple[Array | None, bool]:
        """By how much zeros jumped, and whether the run begins anew; `fault` and `since_s` are as of this tick."""
        free = (self.fault <= Fault.JUDGED) & tick.read
        out = free & tick.beyond
        hot, count = out & self._heat, (free & self._heat).sum()
        if 2 * hot.sum() > count or count < FEWEST:
            hot &= ~self._left_by_the_model(tick)
        self._beyond = np.where(hot, self._beyond + 1, 0)
        self._at_once = np.where(self._beyond == 1, np.abs(tick.deviation), self._at_once)
        most = 2 * hot.sum() > count
        self._together = self._together + 1 if most else 0
        believed = hot & (self._together >= TOGETHER_TICKS)
        anew = tick.time_s - self._begun_s <= START_S and bool((believed | self._wrong_start(tick, hot)).any())
        held = (self.fault == Fault.JUDGED) & self._heat
        still = free & self._heat & (tick.repeats >= STILL)
        for i, fault in self._suspects.judged(tick, hot if most else hot | still, held, most).items():
            together = Fault.NONE if believed[i] else Fault.JUDGED
            self._set(i, together if most and hot[i] else fault, tick)
        believed |= self._lengths(tick, out & ~self._heat)
        for i in np.flatnonzero(back).tolist():
            self._set(i, Fault.NONE, tick)
        for i in np.flatnonzero(self._stands(tick.repeats)).tolist():
            self._set(i, Fault.STUCK, tick)
        jumped = believed & tick.known
        return (np.where(jumped, tick.deviation, 0.0) if jumped.any() else None), anew

    def _left_by_the_model(self, tick: Tick) -> Array:
        """Thermometers (m,) that have not moved as far as they are off, or went there step by step, as heat does."""
        off = np.abs(tick.deviation)
        gradual = (self._beyond >= TOGETHER_TICKS - 1) & (self._at_once < AT_ONCE * off)
        return np.asarray((tick.moved < STAYED * off) | gradual)

    def _wrong_start(self, tick: Tick, hot: Array) -> Array:
        """Thermometers (m,) that left what the run began with at once, and stay away."""
        return hot & self._begun_with & ~tick.known & (self._beyond >= TOGETHER_TICKS)

    def _lengths(self, tick: Tick, out: Array) -> Array:
        """Lengths (m,) that have been beyond their limit for long enough to be believed; others are held or well."""
        read = tick.read & ~self._heat & (self.fault <= Fault.JUDGED)
        self._held = np.where(out, self._held + 1, np.where(read, 0, self._held))
        believed = out & (self._held >= LENGTH_READINGS)
        self._held[believed] = 0
        stuck = read & (tick.repeats >= STUCK)
        for i in np.flatnonzero(read).tolist():
            held = Fault.JUDGED if out[i] and not believed[i] else Fault.NONE
            self._set(i, Fault.STUCK if stuck[i] else held, tick)
        return believed & ~stuck

    def _set(self, i: int, fault: Fault, tick: Tick) -> None:
        """A channel's fault as of now; it keeps the time at which it was first held."""
        if fault == Fault.NONE:
            self.since_s[i] = np.nan
        elif self.fault[i] == Fault.NONE:
            self.since_s[i] = tick.time_s
        if fault > Fault.JUDGED:
            self._recovery.isolate(i, fault, float(tick.deviation[i]), tick.time_s)
            self._neighbours.forget(i)
        self.fault[i] = fault

    def _silence(self, value: Array) -> Array:
        """For how many ticks each channel has not been read, with each of some ticks, (K, m)."""
        ticks = np.arange(1, len(value) + 1)[:, None]
        return ticks - np.maximum.accumulate(np.where(np.isfinite(value), ticks, -self._silent), axis=0)

    def _forget(self, jump: Array | None) -> None:
        """Levels that say nothing any more: of channels that have not been read, or have another zero."""
        gone = (self._silent >= self._silent_ticks) & (self.fault <= Fault.JUDGED)
        self.fault[gone], self.since_s[gone] = Fault.NONE, np.nan
        if jump is not None:
            gone |= jump != 0.0
            self._rezeroed |= jump != 0.0
            for i in np.flatnonzero(jump).tolist():
                self._neighbours.forget(i)
        if gone.any():
            self._jumps.forget(gone)
