"""Own effects that make no number of a tick: the estimate goes on without them, or is not valid any more."""

from dataclasses import replace

import numpy as np

from estimator.alarms.alarms import Alarm
from estimator.errors import EffectError, SetupError
from estimator.filter import Filter
from estimator.record import Sample, collect
from estimator.step import Mode, Step, Track


class LeftOut:
    """The steps of a filter whose model may fail at any tick.

    alarms  an alarm for each effect that was left out
    why     why there is no estimate until the monitor is started again; empty while there is one
    """

    def __init__(self) -> None:
        self.alarms: dict[tuple[str, str, float], Alarm] = {}
        self.why = ""

    def step(self, filter_: Filter, sample: Sample, also: Filter | None = None) -> Step:
        """A tick; what is left out for it is left out of `also`, too. An estimate that is no number is a bug."""
        while not self.why:
            try:
                step = filter_.step(sample)
            except EffectError as error:
                self._without(error, sample.time_s, [filter_, *([also] if also else [])])
                continue
            if filter_.run is not None and not np.isfinite(filter_.fusion.x).all():
                raise FloatingPointError("the estimate is no number")
            return step
        rows = collect("", [sample])
        none = Track.waiting(filter_.rig.names, rows).step(0, ("no estimate",) * len(filter_.rig.names))
        return replace(none, mode=Mode.INVALID)

    def _without(self, error: EffectError, time_s: float, filters: list[Filter]) -> None:
        try:
            for each in filters:
                each.leave_out(error.effect)
        except SetupError as needed:
            self.why = f"{error}; without it there is no estimate ({needed}): correct it and start again"
            return
        alarm = Alarm("effect", error.effect, time_s, f"{error}; the estimate goes on without {error.effect}")
        self.alarms[alarm.key] = alarm
