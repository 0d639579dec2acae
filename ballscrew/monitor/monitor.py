"""From frames to estimates, alarms and trust, a tick at a time: the part of `live` that knows no bus and no screen."""

import copy
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ballscrew.monitor.left_out import LeftOut
from drivers.budget import Budget
from drivers.bus.missing import PATIENCE_S, Missing
from drivers.frames import Tally
from drivers.received import Received
from drivers.ticker import Ticker
from estimator.alarms.alarms import Alarm, Alarms
from estimator.alarms.trust import Trust, Watch
from estimator.faults.sentences import bed_unread
from estimator.filter import Filter
from estimator.model import Model
from estimator.record import Sample
from estimator.rig import Rig
from estimator.state.gate import Mute
from estimator.state.run import Run
from estimator.state.warmth import Warmth, warmth
from estimator.step import Mode, Step

LATE_TICKS = 2.5  # a bus that brings no frame for so long is silent
MOST_ALONE = 10  # ticks of the model alone at a time: frames that come meanwhile must not wait for it


@dataclass(frozen=True)
class Moment:
    """One tick: what was measured, what is estimated, whether to rely on it, and the alarms that begin and end with it.

    provisional  the bus is silent: the model alone goes on, and this tick is taken back when frames come again
    """

    sample: Sample
    step: Step
    trust: Trust
    begun: tuple[Alarm, ...]
    over: tuple[Alarm, ...]
    provisional: bool = False

    @property
    def mode(self) -> Mode:
        """What the estimate rests on; INVALID where it is not to be relied on."""
        return self.step.mode if self.trust.valid or self.step.mode == Mode.INIT else Mode.INVALID


class Monitor:
    """The estimate of one rig, from frames as they come: the same as `review` makes of a log of these frames.

    late_s  how late a frame may come, on the rig's clock, before that means anything
    tally   what was not used, by reason; its notes are to be taken by who tells them
    active  alarms that are on
    start   how warm the screw was when the run began, where that is known
    resumed_s  the rig's time, s since the first frame, at which this monitor went on with an earlier recording
    """

    def __init__(self, model: Model, rig: Rig, mute: Mute | None = None, late_s: float = 0.0) -> None:
        self.model, self.rig, self.mute, self.late_s = model, rig, mute, late_s
        muted = mute(0.0) if mute else np.zeros(len(rig.names), dtype=bool)
        self._used = int((rig.is_thermometer & ~muted).sum())
        self.tally, self.active = Tally(), dict[tuple[str, str, float], Alarm]()
        self.left_out = LeftOut()
        self.begin()

    def begin(self) -> None:
        """Anew: with the first frame, and after a silence that ends a recording."""
        self.ticker, self.filter = Ticker(self.rig, self.tally), Filter(self.model, self.rig, self.mute)
        self.tests, self.watch = Alarms(self.rig), Watch(self.rig, self._used)
        decoder = self.ticker.decoder
        self.missing = Missing(decoder.used, self.rig.tick_s)
        from_drive = [s for group in decoder.sources.values() for s in group if s.name == "speed"]
        self._drive = {(s.message.id, s.message.extended) for s in from_drive}
        self._ahead: tuple[Ticker, Filter] | None = None
        self._undecided: list[Received] = []
        self._silent_s = self._before_s = 0.0
        self.resumed_s: float | None = None
        self.start: Warmth | None = None
        self._run: Run | None = None
        self._waits_for_bed = self.rig.bed is not None

    def forget_what_was_told(self) -> None:
        """Alarms that are on begin anew, and what was noticed so far counts no more."""
        self.active = {}
        for told in (self.tally.skipped, self.tally.notes, self.tally.refused):
            told.clear()

    def feed(self, frame: Received) -> Iterator[Moment]:
        """Take one frame."""
        if frame.kind != "data":
            self.tally.skip(f"{frame.kind} frame")
            return
        frame = frame._replace(id=self.ticker.addresses.id_of(frame.id, frame.extended))
        clock, key, before = self.ticker.clock, (frame.id, frame.extended), self.ticker.frames
        samples = self.ticker.feed(frame.time_s, *key, frame.data)
        if self.ticker.frames > before:  # else it is ours, or its stamp is absurd
            self._ahead = None
            self._silent_s = self._before_s = self._silent_s if clock.waiting else 0.0
        self.missing.heard(*key, clock.now)
        if key in self._drive:
            self.watch.drive(clock.now)
        yield from map(self._moment, samples)
        self._undecided = [*self._undecided, frame] if clock.waiting or clock.ended else []
        if clock.ended:
            yield from self._again()

    def _again(self) -> Iterator[Moment]:
        """The recording has ended with a long silence: begin another with the frames after it."""
        after = self._undecided
        yield from self.finish()
        self.tally.skipped.pop("after the end of the recording", None)
        self.tally.note("the estimate begins anew")
        self.begin()
        for frame in after:
            yield from self.feed(frame)

    def finish(self) -> Iterator[Moment]:
        """No more frames come."""
        return map(self._moment, self.ticker.flush())

    def idle(self, silent_s: float) -> Iterator[Moment]:
        """No frame has come for so long, on the rig's clock: the model goes on alone, a few ticks at a time.

        It goes on from the last stamp that counts: one in doubt may be years ahead.
        """
        silent_s = self._silence(silent_s)
        if not self.ticker.frames or not LATE_TICKS * self.rig.tick_s < silent_s - self.late_s < Budget().gap_s:
            return
        if self._ahead is None:
            shared = {id(each): each for each in (self.rig, self.model, self.ticker.decoder.dbc)}
            self._ahead = copy.deepcopy((self.ticker, self.filter), shared)
            self._ahead[0].tally = self._ahead[0].clock.tally = Tally()
        ticker, alone = self._ahead
        upto = min(self.ticker.clock.stamp + silent_s, ticker.clock.stamp + MOST_ALONE * self.rig.tick_s)
        for sample in ticker.advance(upto):
            step = self.left_out.step(alone, sample, self.filter)
            silent = Alarm("bus", "", self.ticker.clock.now, "nothing of the rig on the bus")
            alarms = {silent.key: silent, **self.left_out.alarms, **self.tests.active}
            yield Moment(sample, step, self._trust(silent_s), *self._changed(alarms), True)

    def trust(self, silent_s: float) -> Trust:
        """Whether the estimate is to be relied on when no frame has come for so long, on the rig's clock."""
        return self._trust(self._silence(silent_s))

    def _trust(self, silent_s: float) -> Trust:
        return self._sure(self.watch.trust(self.ticker.clock.now + max(0.0, silent_s - self.late_s)))

    def _sure(self, trust: Trust) -> Trust:
        """Nothing is to be relied on where there is no estimate; and whether it counts from a warm screw."""
        trust = replace(trust, began_warm=self.start is not None and self.start.warm and not self.start.counted)
        return replace(trust, why=(self.left_out.why,)) if self.left_out.why else trust

    def _silence(self, silent_s: float) -> float:
        """How long no frame has come that counts, where none at all has come for so long, s on the rig's clock."""
        self._silent_s = self._before_s + silent_s
        return self._silent_s

    def _moment(self, sample: Sample) -> Moment:
        step = self.left_out.step(self.filter, sample)
        self.model = self.filter.model
        if self.filter.run is not None:
            self._began(self.filter.run)
        self.tests.step(step)
        self.watch.tick(sample, step, self.tests.diverged)
        for name in self.missing.never(step.time_s):
            self.tally.note(f"{name} has not come yet")
        self._note_bed(step)
        absent = {alarm.key: alarm for alarm in self._absent(step.time_s)}
        changed = self._changed(absent | self.left_out.alarms | self.tests.active)
        return Moment(sample, step, self._sure(self.watch.trust(step.time_s)), *changed)

    def _began(self, run: Run) -> None:
        """Where a run has begun anew: was the screw cold?"""
        if self._run is None or run.x is not self._run.x:
            self._run, self.start = run, warmth(run)
            self.note_start()

    def note_start(self) -> None:
        """Tell where the run began warm."""
        if self.start is not None and self.start.warm:
            self.tally.note(self.start.sentence)

    def _note_bed(self, step: Step) -> None:
        """Tell once why there is no error at the table, where it is for the bed that it is told against."""
        unread = np.isfinite([step.elongation_um, step.position_mm]).all() and np.isnan(step.error_at_table_um)
        if self._waits_for_bed and self.rig.bed and unread and step.time_s >= PATIENCE_S:
            self.tally.note(bed_unread(self.rig.bed))
            self._waits_for_bed = False

    def _absent(self, now_s: float) -> Iterator[Alarm]:
        missing = list(self.missing.since(now_s))
        if missing and len(missing) == self.missing.count:
            yield Alarm("bus", "", max(since_s for _, since_s in missing), "nothing of the rig on the bus")
            return
        for name, since_s in missing:
            yield Alarm("missing", name, since_s, f"{name} is missing")

    def _changed(self, now: dict[tuple[str, str, float], Alarm]) -> tuple[tuple[Alarm, ...], tuple[Alarm, ...]]:
        """The alarms that begin and that end, where these are on now."""
        begun = tuple(alarm for key, alarm in now.items() if key not in self.active)
        over = tuple(alarm for key, alarm in self.active.items() if key not in now)
        self.active = now
        return begun, over
