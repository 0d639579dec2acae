"""Alarms: where the rig and the model part, and readings that cannot be right."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from estimator.alarms.window import FALSE_S, WINDOWS, WindowTest
from estimator.faults.fault import ELSEWHERE, MAY_DRIFT, Fault
from estimator.faults.sentences import place_of
from estimator.record import Array
from estimator.rig import Rig
from estimator.step import Step

SILENT_TICKS = 10
ANOTHER, STILL_ANOTHER = 0.15, 0.1  # share by which parameters are off on a machine that is not the model's
ANOTHER_S = 60.0  # for so long
LACKS_K, STILL_LACKS_K = 0.2, 0.1  # of heat that no effect stands for


@dataclass(frozen=True)
class Alarm:
    """What is wrong, with which channel ("": all of them), and since when, s since the first frame.

    kind    "bias", "nis", "scatter", "rejected", "silent", "may drift", "heat", "machine", "position", or the word of a
            Fault of a channel or an input
    over_s  of a test, how long the readings were looked at; 0: as they come
    """

    kind: str
    channel: str
    since_s: float
    text: str
    over_s: float = 0.0

    @property
    def key(self) -> tuple[str, str, float]:
        """What makes it the same alarm at another time."""
        return self.kind, self.channel, self.over_s


class Alarms:
    """The alarms of one rig, a tick at a time; `active` holds those that are on.

    A test raises its alarm at the end of its window, and the next window that passes it ends the alarm.
    """

    def __init__(self, rig: Rig, false_s: float = FALSE_S) -> None:
        self.rig = rig
        self.active: dict[tuple[str, str, float], Alarm] = {}
        self._tests = [WindowTest(rig, window, false_s) for window in WINDOWS]
        self._inputs_since: dict[tuple[str, Fault], float] = {}
        self._heat = rig.is_thermometer
        self._silent = np.full(len(rig.names), -1)  # ticks since the last reading, -1: never read
        self._another_s = np.nan  # since when the machine is not the model's
        self._elsewhere_s = np.nan  # since when the nut's heat is not where the position says

    @property
    def diverged(self) -> bool:
        """Whether NIS says that the estimate cannot be trusted."""
        return any(alarm.kind == "nis" for alarm in self.active.values())

    def step(self, step: Step) -> tuple[list[Alarm], list[Alarm]]:
        """Take one tick; returns the alarms that begin with it, and those that end."""
        heat = self._heat & (np.array(step.why, dtype=object) != "muted")
        found, judged = [*self._silences(step, heat), *self._faults(step, heat), *self._inputs(step)], {0.0}
        found += [*self._machine(step), *self._place(step), *self._lacking(step)]
        for test in self._tests:
            if test.add(step):
                judged.add(test.over_s)
                found += [Alarm(kind, name, test.first_s, text, test.over_s) for kind, name, text in test.failed()]
        now = {alarm.key: alarm for alarm in found}
        begun = [alarm for key, alarm in now.items() if key not in self.active]
        over = [alarm for key, alarm in self.active.items() if alarm.over_s in judged and key not in now]
        for alarm in over:
            del self.active[alarm.key]
        self.active.update({alarm.key: alarm for alarm in begun})
        return begun, over

    def _silences(self, step: Step, heat: Array) -> Iterator[Alarm]:
        """Thermometers that have been read before and are not now."""
        known = np.isfinite(step.measured)
        self._silent[known] = 0
        self._silent[~known & (self._silent >= 0)] += 1
        gone = heat & (self._silent >= SILENT_TICKS)
        since = step.time_s - self._silent * self.rig.tick_s
        if gone.any() and gone.sum() == (heat & (self._silent >= 0)).sum():
            yield Alarm("silent", "", float(since[gone].max()), "no thermometer is read")
            return
        for i in np.flatnonzero(gone):
            yield Alarm("silent", self.rig.names[i], float(since[i]), f"{place_of(self.rig, i)} is not read")

    def _faults(self, step: Step, heat: Array) -> Iterator[Alarm]:
        """Thermometers that are broken, and those that may be."""
        if not (step.fault.any() or step.may_drift_K.any()):
            return
        for i in np.flatnonzero((heat | ~self._heat) & (step.fault > Fault.JUDGED)):
            fault = Fault(step.fault[i])
            at = (
                f" at {step.measured[i]:.2f} {self.rig.channels[self.rig.names[i]].unit}"
                if fault == Fault.STUCK and np.isfinite(step.measured[i])
                else ""
            )
            text = f"{place_of(self.rig, i)} {fault.said}{at}"
            yield Alarm(fault.word, self.rig.names[i], float(step.since_s[i]), text)
        for i in np.flatnonzero(heat & (step.may_drift_K != 0) & (step.fault == Fault.NONE)):
            text = f"{place_of(self.rig, i)} {MAY_DRIFT} away from its neighbours; it is used"
            yield Alarm(MAY_DRIFT, self.rig.names[i], float(step.since_s[i]), text)

    def _lacking(self, step: Step) -> Iterator[Alarm]:
        """Heat that the model lacks, at thermometers that are right."""
        for i in np.flatnonzero(step.lacks_K):
            name = self.rig.names[i]
            if abs(step.lacks_K[i]) > (STILL_LACKS_K if ("heat", name, 0.0) in self.active else LACKS_K):
                by = f"{step.lacks_K[i]:+.1f} K beside its neighbours"
                yield Alarm("heat", name, step.time_s, f"the model lacks heat at {place_of(self.rig, i)}: {by}")

    def _machine(self, step: Step) -> Iterator[Alarm]:
        """A machine that is not the model's."""
        off = step.off_share > (STILL_ANOTHER if ("machine", "", 0.0) in self.active else ANOTHER)
        self._another_s = np.fmin(self._another_s, step.time_s) if off else np.nan
        if step.time_s - self._another_s >= ANOTHER_S:
            by = f"its parameters are off by some {step.off_share:.0%}; the estimate's sd allows for it"
            yield Alarm("machine", "", float(self._another_s), f"the model is not this machine's: {by}")

    def _place(self, step: Step) -> Iterator[Alarm]:
        """Heat that stands elsewhere than the position says."""
        self._elsewhere_s = np.fmin(self._elsewhere_s, step.time_s) if step.shift_mm else np.nan
        if step.shift_mm:
            by = f"as if it were off by {step.shift_mm:+.0f} mm; check its zero, and what else heats there"
            yield Alarm("position", "", float(self._elsewhere_s), f"{ELSEWHERE}: {by}")

    def _inputs(self, step: Step) -> Iterator[Alarm]:
        """Inputs that are held; what is stuck may be as it was, and stays as it is."""
        if not np.any(step.input_fault):
            self._inputs_since = {}
            return
        for name, code in zip(self.rig.inputs, step.input_fault):
            fault = Fault(code)
            if fault > Fault.JUDGED:
                since_s = self._inputs_since.setdefault((name, fault), step.time_s)
                held = "; its last temperature is held" if fault == Fault.JUMPED else ""
                yield Alarm(fault.word, name, since_s, f"input {name} {fault.said}{held}")
        on = {(name, Fault(code)) for name, code in zip(self.rig.inputs, step.input_fault)}
        self._inputs_since = {key: since_s for key, since_s in self._inputs_since.items() if key in on}
