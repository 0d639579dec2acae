"""What the monitor says of itself: rows for a person, one line for a log, one JSON line a tick for programs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ballscrew.monitor.monitor import Moment
from ballscrew.terminal import duration
from drivers.frames import Tally
from estimator.alarms.alarms import Alarm
from estimator.faults.fault import MAY_DRIFT, Fault
from estimator.rig import Rig
from viz.drawing.scale import clock

NO_FRAME = ("tick ", "scan ", "fault bit ", "further notes")  # counted, and no frame was lost
NO_DEFECT = ("unknown id", "not in the rig file", "held since before the log", "sent by us", "other state")


@dataclass(frozen=True)
class Status:
    """The state of the monitor at one moment; `moment` is None before the first tick.

    age_s      how old the latest frame was when it was taken
    resumed_s  since when the estimate is this monitor's, s since the first frame; before that it was an earlier one's
    motion     whether the table drives, and since when;   published  whether the estimate goes to a control
    dropped    frames that came and were not used;   refused  readings of channels and inputs that were none
    judged_s   since when the estimate has been valid or not, s since the first frame
    ended      nothing comes any more
    """

    rig: Rig
    moment: Moment | None
    alarms: tuple[Alarm, ...]
    bus: str
    frames: int
    frames_per_s: float
    age_s: float
    resumed_s: float | None
    dropped: int
    refused: Mapping[str, int]
    skipped: Mapping[str, int]
    recording: str
    publishing: str
    views: str
    motion: str = ""
    published: str = ""
    judged_s: float = 0.0
    ended: bool = False

    def line(self) -> str:
        """For a terminal that cannot."""
        return "; ".join(f"{name} {text}" for name, text in self.rows() if name not in ("views", "alarm"))

    def markdown(self) -> str:
        """For the views, beside what they show in large letters."""
        return "\n".join(["| | |", "|---|---|", *(f"| {name} | {text} |" for name, text in self.rows())])

    @property
    def thermometers(self) -> str:
        """How many thermometers the estimate rests on."""
        count = fused_thermometers(self.moment, self.rig) if self.moment else 0
        return f"{count} of {len(self.rig.thermometers)} thermometers"

    def rows(self) -> list[tuple[str, str]]:
        """What it is about, and how that is."""
        rows = (
            [*_estimate(self.moment, self.thermometers)]
            if self.moment
            else [("elongation", "waiting for the first tick")]
        )
        if self.resumed_s is not None:
            rows.append(("resumed", f"after {duration(self.resumed_s)} of an earlier recording"))
        rows.append(("bus", f"{self.bus}, {self.frames} frames, {self.frames_per_s:.0f}/s, {self.dropped} dropped"))
        if defects := ", ".join(f"{count} x {reason}" for reason, count in self.skipped.items()):
            rows.append(("noticed", defects))
        rows.append(("recording", self.recording))
        rows += [("publishing", self.publishing)] if self.publishing else []
        rows += [("views", self.views)] if self.views else []
        return rows + [("alarm", f"{alarm.text}, since {clock(alarm.since_s)}") for alarm in self.alarms]

    def json(self) -> dict[str, Any]:
        """For programs; `t` is in s since the first frame."""
        assert self.moment is not None
        step = self.moment.step
        return {
            "t": step.time_s, "elongation_um": step.elongation_um, "sigma_um": step.sigma_um,
            "error_at_table_um": step.error_at_table_um, "mode": self.moment.mode.name.lower(),
            "channels": fused_thermometers(self.moment, self.rig), "nis": step.nis, "frames": self.frames,
            "age_s": self.age_s, "dropped": self.dropped, "refused": self.refused,
            "alarms": [
                {"kind": a.kind, "channel": a.channel, "since_s": a.since_s, "text": a.text} for a in self.alarms
            ],
            "resumed_s": self.resumed_s, "provisional": self.moment.provisional,
            "why_invalid": list(self.moment.trust.why), "suspects": _suspects(self.alarms),
            "off_share": step.off_share, "shift_mm": step.shift_mm,
        }  # fmt: skip


def _suspects(alarms: Sequence[Alarm]) -> list[dict[str, Any]]:
    """Channels and inputs that are left out, how and since when; and thermometers that may drift, which are not."""
    words = {fault.word for fault in Fault if fault.word} | {MAY_DRIFT}
    return [{"channel": a.channel, "suspect": a.kind, "since_s": a.since_s} for a in alarms if a.kind in words]


def defects(skipped: Mapping[str, int]) -> dict[str, int]:
    """What was not used though it should have been."""
    return {reason: count for reason, count in skipped.items() if not reason.startswith(NO_DEFECT)}


def frames_lost(tally: Tally) -> int:
    """How many frames came and were not used; of some defects the rest can be used all the same."""
    lost = {reason: n for reason, n in defects(tally.counts()).items() if reason not in tally.of_readings}
    return sum(n for reason, n in lost.items() if not reason.startswith(NO_FRAME) and not reason.endswith("(used)"))


def fused_thermometers(moment: Moment, rig: Rig) -> int:
    """Thermometers that the estimate of this tick rests on."""
    return int(moment.step.fused[rig.is_thermometer].sum())


def _estimate(moment: Moment, thermometers: str) -> list[tuple[str, str]]:
    step, mode = moment.step, moment.mode.name.lower()
    rows = [("time", f"{duration(step.time_s)} since the first frame")]
    if np.isfinite(step.elongation_um):
        at_table = f", {step.error_at_table_um:+.2f} ± {2 * step.error_at_table_sd_um:.2f} um at the table"
        table = at_table if np.isfinite(step.error_at_table_um) else ""
        rows.append(("elongation", f"{step.elongation_um:+.2f} ± {2 * step.sigma_um:.2f} um (2 sd){table}"))
    why = f": {', '.join(moment.trust.why)}" if moment.trust.why else ""
    rows.append(("mode", f"{mode}{why}{' (no frames: the model alone)' if moment.provisional else ''}"))
    per_channel = f"{step.nis / step.nis_channels:.2f}" if np.isfinite(step.nis) else "-"
    return [*rows, ("channels", f"{thermometers}, NIS {per_channel} a channel")]
