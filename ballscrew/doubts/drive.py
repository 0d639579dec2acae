"""Doubts about the drive: a speed that is not how fast the position changes, and a nut that leaves the screw."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ballscrew.doubts.doubt import Case, Doubt
from ballscrew.new_rig.drive import EVEN, fit_of, lead_of, rate_of
from ballscrew.new_rig.seen import Seen

_MOVES = 5e-3  # in mm or, where that is wrong, m
_M_IN_MM = 1000.0
_DENSE = 0.2  # of the stroke: further apart, positions say nothing of the speed between them
_UNLIKE, _OFF = 0.5, 0.15  # correlation, and share by which the lead may differ


def drive(case: Case) -> Iterator[Doubt]:
    """Speed against position, and position against the screw."""
    yield from _nut(case)
    speed, place = _scaled(case, "speed"), _scaled(case, "position")
    if speed is None or place is None or place.width < _MOVES or not _is_dense(place):
        return
    if not np.abs(speed.value).max():
        what = f"always 0, while the table moves by {place.width:.0f} mm"
        yield Doubt(case.place("inputs", "speed"), what, "name the signal of the measured speed")
    elif fit_of(speed, place) < _UNLIKE:
        what = "it is not how fast the position changes"
        yield Doubt(case.place("inputs", "speed"), what, "look whether both are of this axis, and measured values")
    elif case.rig.screw and (lead := lead_of(speed, place)) and abs(lead / case.rig.screw.lead_mm - 1) > _OFF:
        ratio = case.rig.screw.lead_mm / lead
        what = f"{lead:g} mm a turn by speed and position, screw.lead_mm is {case.rig.screw.lead_mm:g}"
        fix = "correct the lead, or unit and scale of speed or position"
        if 1 - _OFF < ratio / _M_IN_MM < 1 + _OFF:
            yield Doubt(case.place("inputs", "position"), f"{what}: in m?", "then scale = 1000")
        else:
            yield Doubt(case.place("inputs", "speed"), what, fix)


def _nut(case: Case) -> Iterator[Doubt]:
    screw, nut, position = case.rig.screw, case.rig.nut, case.recording.inputs.get("position", np.empty(0))
    known = position[np.isfinite(position)]
    if screw is None or nut is None or not len(known):
        return
    low, high = np.sort(nut.centre(np.array([known.min(), known.max()])))
    if low < screw.from_mm or high > screw.to_mm:
        what = f"its centre goes to {low:.0f} ... {high:.0f} mm, the screw is {screw.from_mm:g} ... {screw.to_mm:g} mm"
        yield Doubt("rig.toml: nut", what, "correct centre_mm and direction, or unit and scale of the position")


def _scaled(case: Case, name: str) -> Seen | None:
    """A signal of the drive in mm or rpm, as rig.toml reads it; None where it never came."""
    rule = case.rig.inputs.get(name)
    found = case.of(name, rule) if rule else []
    if not rule or not found or len(found[0].time) < 2:
        return None
    return replace(found[0], value=rule.scale * found[0].value + rule.offset, unit=rule.unit)


def _is_dense(place: Seen) -> bool:
    """Whether positions change unevenly, and come often enough to tell how fast."""
    _, rate = rate_of(place)
    steps = np.abs(np.diff(place.value))
    moving = steps > 1e-3 * place.width
    uneven = len(rate) > 0 and np.std(np.abs(rate)) > EVEN * np.abs(rate).mean()
    return bool(uneven and moving.any() and np.median(steps[moving]) < _DENSE * place.width)
