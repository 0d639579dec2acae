"""Positions of the table at which an axis' drift is told: named, or those of the stroke."""

import numpy as np

from estimator.errors import SetupError
from estimator.record import Recording
from estimator.rig import Rig

PLACES = 9  # over the stroke, at which the error at the table is told


def stroke(recording: Recording) -> tuple[float, float] | None:
    """Lowest and highest position of the table in a recording, mm; None where it is not read."""
    position = recording.inputs.get("position", np.empty(0))
    return (float(np.nanmin(position)), float(np.nanmax(position))) if np.isfinite(position).any() else None


def over_stroke(recording: Recording, rig: Rig) -> list[float]:
    """Positions of the table from end to end of its stroke, mm; none without a nut."""
    ends = stroke(recording) if rig.nut is not None else None
    return [] if ends is None else np.linspace(*ends, PLACES).tolist()


def ends_and_middle(recording: Recording) -> list[float]:
    """Positions of the table at the ends of its stroke in a recording, and between them: whole mm; none without one."""
    ends = stroke(recording)
    if ends is None or ends[1] - ends[0] < 2.0:
        return []
    return [float(np.round(one)) for one in (ends[0], sum(ends) / 2, ends[1])]


def positions(text: str, rig: Rig) -> list[float]:
    """`20,380` as positions of the table, mm: two or three, at which the nut is on the screw."""
    try:
        at = sorted({float(word) for word in text.split(",")})
    except ValueError:
        raise SetupError(f"--at {text}: write two or three positions of the table in mm, like 20,200,380") from None
    if len(at) not in (2, 3):
        raise SetupError(f"--at {text}: two or three different positions are needed, like 20,200,380")
    screw, nut = rig.the_screw(), rig.the_nut()
    for one in at:
        if not screw.from_mm <= (centre := float(nut.centre(np.array(one)))) <= screw.to_mm:
            raise SetupError(
                f"--at {one:g}: the nut's centre would be at {centre:g} mm, beside the screw "
                f"({screw.from_mm:g} ... {screw.to_mm:g} mm)"
            )
    return at
