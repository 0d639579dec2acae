"""The loop of `live`: frames in; estimates, alarms, views, status and, where asked for, frames out."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ballscrew.monitor.drives import Drives
from ballscrew.monitor.explainer import Explainer
from ballscrew.monitor.glance import glances
from ballscrew.monitor.monitor import Moment, Monitor
from ballscrew.monitor.resume import resume
from ballscrew.monitor.status import Status, defects, frames_lost
from drivers.bus.publisher import Publisher
from drivers.bus.receiver import Receiver
from drivers.bus.rig_time import RigTime
from drivers.received import Notice, Received
from drivers.recorder.recorder import Recorder
from drivers.ticker import Ticker
from estimator.alarms.trust import Trust
from estimator.step import Mode
from viz.drawing.scale import clock
from viz.lanes.standing import Standing

if TYPE_CHECKING:
    from viz.live.live import LiveViews  # rerun takes half a second to import

WAIT_S = 0.05  # half of what the bus may wait for an invalid frame
RATE_S = 5.0  # frames per second are counted over
BEHIND_S = 0.5  # that a frame may be old
LOOK_S = 0.1  # between two looks at how things are: with each frame they would cost more than the estimate
DRAIN_S = 0.5  # for what has come but is not estimated yet when the end is asked for
SHOWN_S = 1.0  # between two states of the monitor in the views
PLACES = 61  # of the table, at which its error is told


@dataclass
class Session:
    """Everything that a monitor is made of; what is None was not asked for.

    say   hears sentences for the person: text, level
    tick  hears of every tick; None: nobody asks
    earlier  parts of the recording to go on with
    """

    monitor: Monitor
    receiver: Receiver
    clock: RigTime
    bus: str
    say: Callable[[str, str], None]
    tick: Callable[[Status], None] | None = None
    recorder: Recorder | None = None
    publisher: Publisher | None = None
    views: LiveViews | None = None
    views_at: str = ""
    earlier: list[Path] = field(default_factory=list)
    explainer: Explainer | None = None
    latest: Moment | None = None
    _rate: deque[tuple[float, int]] = field(default_factory=deque)
    _looked: float = 0.0
    _shown: float = 0.0
    _fresh: bool = False
    _was_valid: bool | None = None
    _judged_s: float = 0.0
    _ended: bool = False
    _drives: Drives = field(default_factory=Drives)
    _ticker: Ticker | None = None
    _troubles: dict[str, str] = field(default_factory=dict)
    _goes_on: Callable[[], bool] = lambda: True
    _end: float = math.inf

    def run(self, goes_on: Callable[[], bool], show: Callable[[Status], None]) -> None:
        """Until `goes_on` says no; `show` hears the status ten times a second."""
        self._goes_on = goes_on
        self.receiver.start()
        if self.publisher is not None:
            self.publisher.start()
        if self.earlier:
            self._say(f"reads {len(self.earlier)} recorded parts from {self.earlier[0]} on, to go on with them", "INFO")
            self._say(resume(self.monitor, self.earlier, goes_on), "INFO")
        self._ticker = self.monitor.ticker
        while goes_on():
            self._show_status()
            self._take(self.receiver.take(WAIT_S))
            if self.receiver.failure is not None:
                raise self.receiver.failure
            self._idle()
            self._publish()
            if time.monotonic() - self._looked > LOOK_S:
                self._looked = time.monotonic()
                self._tell()
                self._explain()
                show(self.status())

    def finish(self) -> None:
        """The end: stop receiving, take what has come, and close the open tick as `review` does at the end of a log."""
        late = self._late()
        self.receiver.stop()
        self._end = 0.0 if late else time.monotonic() + DRAIN_S
        while items := self.receiver.take(0.0):
            self._take(items)
        self._all(self.monitor.finish)
        if self._late():
            self._say("ended behind the bus: what came last is not in the estimate", "WARN")
        self._publish()
        self._tell()
        self._ended = True
        self._shown = -math.inf
        self._show_status()

    def _late(self) -> bool:
        """Whether the end was asked for, and not just now: a single frame after a silence closes thousands of ticks."""
        if self._end == math.inf and not self._goes_on():
            self._end = time.monotonic() + DRAIN_S
        return time.monotonic() > self._end

    def _take(self, items: list[Received | Notice]) -> None:
        for item in items:
            if isinstance(item, Notice):
                self._say(item.text, item.level)
                continue
            self._all(partial(self.monitor.feed, item))

    def _all(self, moments: Callable[[], Iterator[Moment]]) -> None:
        """All of these moments, as long as there is time."""
        estimated = self._estimated(moments)
        while not self._late() and (moment := next(estimated, None)):
            self._moment(moment)

    def _estimated(self, moments: Callable[[], Iterator[Moment]]) -> Iterator[Moment]:
        """Moments; none if the estimate fails: a defect of ours must not end weeks of recording."""
        try:
            yield from moments()
        except Exception as error:
            self.monitor.begin()
            self._trouble("estimate", f"the estimate failed and begins anew: {type(error).__name__}: {error}")

    def _idle(self) -> None:
        """No frame: the model goes on alone, and who relies on the estimate hears that it is not to be trusted."""
        silent_s = self.clock.silence()
        if not self.receiver.waiting:  # else the rig has said more than is estimated so far
            self._all(partial(self.monitor.idle, silent_s))
        if self.latest is not None and self.latest.trust.valid:
            self._judge(self.monitor.trust(silent_s))

    def _moment(self, moment: Moment) -> None:
        if self.views is not None and self.monitor.ticker is not self._ticker:
            self.views.begin()
        self._ticker = self.monitor.ticker
        self.latest, self._fresh = moment, True
        self._judge(moment.trust)
        for alarm in moment.begun:
            self._say(f"alarm: {alarm.text}, since {clock(alarm.since_s)}", "WARN")
        for alarm in moment.over:
            self._say(f"over: {alarm.text}", "INFO")
        if not moment.provisional:
            self._drive(moment)
        self._show_status()
        if self.tick is not None:
            self.tick(self.status())

    def _drive(self, moment: Moment) -> None:
        """Show a tick, and tell of a drive or stop that it makes certain."""
        if self.views is not None:
            self.views.show(moment.sample, moment.step)
        if (turn := self._drives.tick(moment.sample, moment.step)) is not None:
            self._say(turn.text, "INFO", turn.since_s)

    def _judge(self, trust: Trust) -> None:
        """Whether the latest estimate is to be relied on; tell of a change."""
        assert self.latest is not None
        if self.receiver.age_s > BEHIND_S:
            trust = replace(trust, why=(*trust.why, "the monitor is behind"))
        if trust.valid != self.latest.trust.valid or trust.why != self.latest.trust.why:
            self.latest, self._fresh = replace(self.latest, trust=trust), True
        if self._was_valid is not None and trust.valid != self._was_valid and self.latest.step.mode != Mode.INIT:
            why = "" if trust.valid else f" no longer: {', '.join(trust.why)}"
            self._say(f"estimate valid{why or ' again'}", "INFO" if trust.valid else "WARN")
        if trust.valid != self._was_valid or self.latest.step.time_s < self._judged_s:
            self._judged_s = self.latest.step.time_s
        if self.views is not None:
            alarms = tuple(self.monitor.active.values())
            self.views.judge(self.latest.step.time_s, trust.why, alarms, self._published(trust))
        self._was_valid = trust.valid if self.latest.step.mode != Mode.INIT else None

    def _published(self, trust: Trust) -> str:
        """Whether the estimate goes to a control, and why not."""
        if self.publisher is None:
            return "not asked for (--publish)"
        return self.publisher.trouble or ("sent" if trust.valid else "sent as invalid")

    def _publish(self) -> None:
        """What is newest, once a turn: a control has no use for what was."""
        if self.publisher is not None and self.latest is not None and self._fresh:
            self.publisher.send(self.latest.step, self.latest.trust, self.latest.step.position_mm)
        self._fresh = False

    def _show_status(self) -> None:
        """How things stand, also while no tick comes: what is old must not look like news."""
        if self.views is None or time.monotonic() - self._shown <= SHOWN_S:
            return
        self._shown, status, latest = time.monotonic(), self.status(), self.latest
        stroke = self.monitor.rig.stroke_mm
        fresh = latest is not None and not latest.provisional and latest.step.mode != Mode.INIT
        table = self.monitor.filter.table_errors(np.linspace(*stroke, PLACES)) if stroke and fresh else None
        time_s = latest.step.time_s if latest else 0.0
        self.views.stand(Standing(time_s, glances(status), status.markdown(), table))

    def _tell(self) -> None:
        """New sentences of the clock, the recorder, the publisher and the views."""
        notes, self.monitor.tally.notes = self.monitor.tally.notes, []
        if self.recorder is not None:
            while self.recorder.notes:
                notes.append(self.recorder.notes.pop(0))
        for note in notes:
            self._say(note, "WARN")
        for part in ("clock", "recorder", "publisher", "views", "tick"):
            self._trouble(part, getattr(getattr(self, part), "trouble", ""))

    def _explain(self) -> None:
        """Ask what has changed while rig and model part, and say it once it is known."""
        if self.explainer is not None and (answer := self.explainer.look(self.monitor.active.values())):
            self._say(answer, "WARN")

    def _trouble(self, part: str, trouble: str) -> None:
        """Say what is wrong with a part, once."""
        if trouble and trouble != self._troubles.get(part):
            self._say(trouble, "WARN")
        self._troubles[part] = trouble

    def _say(self, text: str, level: str, at_s: float | None = None) -> None:
        """A sentence for the person, of now or of a time, s since the first frame."""
        self.say(text, level)
        if self.views is not None:
            now_s = self.latest.step.time_s if self.latest else 0.0
            self.views.say(now_s if at_s is None else at_s, text, level)

    def status(self) -> Status:
        """How things are."""
        tally = self.monitor.tally
        lost = self.recorder.lost if self.recorder else 0
        publisher = self.publisher
        sent = f"{publisher.sent} frames sent" if publisher else ""
        turn, latest = self._drives.now if self.monitor.rig.moves else None, self.latest
        motion = f"{'driving' if turn.driving else 'at rest'} since {clock(turn.since_s)}" if turn else ""
        errors = f", {self.receiver.errors} error frames" if self.receiver.errors else ""
        return Status(
            rig=self.monitor.rig, moment=self.latest, alarms=tuple(self.monitor.active.values()),
            bus=f"{self.bus} {self.receiver.state}{errors}", frames=self.receiver.frames,
            frames_per_s=self._frames_per_s(), age_s=self.receiver.age_s, resumed_s=self.monitor.resumed_s,
            dropped=self.receiver.missed + self.receiver.dropped + lost + frames_lost(tally),
            refused={name: count for name, count in tally.refused.items() if count}, skipped=defects(tally.counts()),
            recording=(self.recorder.trouble or str(self.recorder.path)) if self.recorder else "none (--record DIR)",
            publishing=(publisher.trouble or sent) if publisher else "", views=self.views_at, motion=motion,
            published=self._published(latest.trust) if latest and publisher else "", judged_s=self._judged_s,
            ended=self._ended,
        )  # fmt: skip

    def _frames_per_s(self) -> float:
        now, frames = time.monotonic(), self.receiver.frames
        if not self._rate or now - self._rate[-1][0] > WAIT_S:
            self._rate.append((now, frames))
        while self._rate and now - self._rate[0][0] > RATE_S:
            self._rate.popleft()
        first, before = self._rate[0] if self._rate else (now, frames)
        return (frames - before) / (now - first) if now > first else 0.0
