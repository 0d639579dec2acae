"""A monitor that is started again goes on with the recording that has just ended, as if it had never stopped."""

from collections.abc import Callable
from pathlib import Path

from ballscrew.monitor.monitor import Monitor
from ballscrew.terminal import duration
from drivers.recorder.earlier import frames_of


def resume(monitor: Monitor, parts: list[Path], goes_on: Callable[[], bool]) -> str:
    """Feed the frames of these parts; what happened in them was told then, and is not again. Returns a sentence.

    The estimate is that of `review --join`. One that fails on the way, or is asked to end, begins with the next frame.
    """
    latest = None
    try:
        for frame in frames_of(parts):
            if not goes_on():
                return "stopped before the recording was read"
            for moment in monitor.feed(frame):
                latest = moment
    except Exception as error:  # a defect of ours must not keep the monitor from starting
        latest, why = None, f"{type(error).__name__}: {error}"
    else:
        why = "no estimate in it"
    monitor.forget_what_was_told()
    if latest is None or monitor.filter.run is None:
        monitor.begin()
        return f"cannot go on with {parts[0].name}, and begins anew: {why}"
    monitor.resumed_s = monitor.ticker.clock.now
    monitor.note_start()
    step, length = latest.step, duration(monitor.resumed_s)
    return (
        f"goes on with {parts[0].name} after {length}, at {step.elongation_um:+.2f} ± {2 * step.sigma_um:.2f} um (2 sd)"
    )
