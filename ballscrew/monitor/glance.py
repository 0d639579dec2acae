"""What is to be read at a glance: the growth, the error at the table, and whether to rely on them, since when and why.

What is not of now is grey: values of an estimate that is not valid, or of the model alone after the rig has ended.
"""

import numpy as np

from ballscrew.monitor.status import Status
from estimator.step import Mode
from viz.drawing.scale import clock
from viz.lanes.standing import Glance, Tone


def glances(status: Status) -> tuple[Glance, ...]:
    """Values first, how far to rely on them last."""
    if status.moment is None:
        return (Glance("estimate", "WAITING", f"for the first tick: {status.bus}", "stale"),)
    fresh = status.moment.trust.valid and not status.moment.provisional and not status.ended
    return (*_values(status, "value" if fresh else "stale"), _validity(status))


def _values(status: Status, tone: Tone) -> list[Glance]:
    """Growth and error at the table; on a rig that does not grow its warmest thermometer."""
    assert status.moment is not None
    step = status.moment.step
    if not np.isfinite(step.elongation_um):
        return _warmest(status, tone)
    values = [Glance("elongation ± 2 sd", _within(step.elongation_um, step.sigma_um), status.motion, tone)]
    if status.rig.stroke_mm:
        sent = [status.published] if status.published else []
        known = np.isfinite(step.error_at_table_um)
        error = _within(step.error_at_table_um, step.error_at_table_sd_um) if known else "not known"
        placed = np.isfinite(step.position_mm)
        place = f"table at {step.position_mm:.0f} mm" if placed else "no position of the table"
        if placed and not known and status.rig.bed:
            place = f"nothing read of {status.rig.bed.input}, the bed's temperature"
        values.append(Glance("error at the table ± 2 sd", error, ", ".join([place, *sent]), tone))
    return values


def _warmest(status: Status, tone: Tone) -> list[Glance]:
    assert status.moment is not None
    step = status.moment.step
    read = np.where(step.fused & status.rig.is_thermometer, step.measured, np.nan)
    if not np.isfinite(read).any():
        return []
    k = int(np.nanargmax(read))
    return [Glance("warmest thermometer that is used", f"{read[k]:.2f} °C", step.names[k], tone)]


def _within(um: float, sd_um: float) -> str:
    """A value with as many digits as mean something, and as there is room for."""
    digits = 2 if 2 * sd_um < 10 else 1 if 2 * sd_um < 100 else 0
    return f"{um:+.{digits}f} ± {2 * sd_um:.{digits}f} µm"


def _validity(status: Status) -> Glance:
    """Whether to rely on the estimate, since when, and why not or which channels are missing."""
    assert status.moment is not None
    moment, since = status.moment, f"since {clock(status.judged_s)}"
    if status.ended:
        return Glance("estimate", "ENDED", f"at {clock(moment.step.time_s)}: the monitor has ended", "stale")
    if moment.provisional:
        silent_s = min((alarm.since_s for alarm in status.alarms if alarm.kind == "bus"), default=moment.step.time_s)
        return Glance("estimate", "NO FRAMES", f"since {clock(silent_s)}: by the model alone, not valid", "stale")
    if moment.step.mode == Mode.INIT:
        return Glance("estimate", "NOT YET", ", ".join(moment.trust.why), "stale")
    if moment.trust.why:
        return Glance("estimate", "INVALID", f"{since}: {', '.join(moment.trust.why)}", "invalid")
    broken = [f"{alarm.channel} {alarm.kind}".strip() for alarm in status.alarms]
    return Glance("estimate", "VALID", "; ".join([since, status.thermometers, *broken]), "valid")
