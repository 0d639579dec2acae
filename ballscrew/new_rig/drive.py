"""Which signals are the drive's speed and position and its current, and which are heaters."""

from collections.abc import Iterator, Sequence

import numpy as np

from ballscrew.new_rig import words
from ballscrew.new_rig.seen import Guess, Seen
from ballscrew.new_rig.words import LEAD_MM
from drivers.frames import Array
from estimator.rig import RAD_S, Signal

_TRAVEL_MM = 5.0  # a position moves by more
_FASTER = 3  # times the usual speed: another recording may be of faster drives
_PEAK = 10  # times the usual current, when the table is accelerated
_MOST_W = 30.0  # without a unit: what gets higher is in %
EVEN = 0.05  # of the mean: what moves as evenly tells nothing of what it moves with
FITS = 0.9  # correlation of two that measure one thing


def drive(seen: Sequence[Seen]) -> list[Guess]:
    """Speed and position, of several those that fit best; then current and heaters."""
    moving = list(_motion(seen))
    return [*moving, *_levels(seen, bool(moving))]


def _motion(seen: Sequence[Seen]) -> Iterator[Guess]:
    """Speed and position: of several the pair that fits best, what is measured before what was asked for."""
    places = [one for one in seen if _is_place(one)]
    speeds = [one for one in seen if _is_speed(one, places)]
    none: list[Seen | None] = [None]
    pairs = [(_score(s, p), s, p) for s in speeds or none for p in places or none]
    _, speed, place = max(pairs, key=lambda pair: pair[0])
    lead = lead_of(speed, place) if speed and place else None
    if speed is not None:
        yield _speed(speed, lead or LEAD_MM, [one for one in speeds if one is not speed], place)
    if place is not None:
        yield _place(place, [one for one in places if one is not place])


def _is_speed(one: Seen, places: Sequence[Seen]) -> bool:
    """Whether it may be the drive's; what is in mm/s may as well be a vibration."""
    named = words.says(one.label, words.SPEED)
    if _kind(one) == "feed":
        return named or any(fit_of(one, place) > FITS for place in places)
    return _kind(one) == "speed" or (bare(one) and named)


def _score(speed: Seen | None, place: Seen | None) -> float:
    """How well speed and position fit each other, and are measured values rather than wanted ones."""
    wanted = sum(one is not None and words.says(one.source, words.WANTED) for one in (speed, place))
    feed = speed is not None and _kind(speed) == "feed"
    moves = sum(one is not None and one.width > 0 for one in (speed, place))
    fit = fit_of(speed, place) if speed and place else 0.0
    return round(fit, 2) + moves - 0.2 * wanted - 0.05 * feed


def rate_of(place: Seen, scale: float = 1.0) -> tuple[Array, Array]:
    """Times in the middle of two readings, (n,) s, and how fast a position changes there, (n,) 1/s."""
    step = np.diff(place.time)
    good = step > 0
    return (place.time[1:][good] + place.time[:-1][good]) / 2, np.diff(place.value)[good] * scale / step[good]


def fit_of(speed: Seen, place: Seen) -> float:
    """How well a speed is the change of a position: correlation of their sizes, 0 ... 1."""
    time, rate = rate_of(place)
    at = np.interp(time, speed.time, np.abs(speed.value)) if len(time) else time
    if len(time) < 10 or not np.std(np.abs(rate)) > EVEN * np.abs(rate).mean() or not np.ptp(at):
        return 0.0
    return max(float(np.corrcoef(at, np.abs(rate))[0, 1]), 0.0)


def lead_of(speed: Seen, place: Seen) -> float | None:
    """The way per turn, mm, where speed and position tell it; None where they do not fit."""
    unit, length = _rotary(speed), words.measure(place.unit)
    time, rate = rate_of(place, length.scale if length and length.kind == "length" else 1.0)
    if fit_of(speed, place) < FITS or unit is None:
        return None
    turns = np.interp(time, speed.time, np.abs(speed.value)) * unit.scale * RAD_S[unit.unit] / (2 * np.pi)
    fast = turns > turns.max() / 2
    return float(f"{float(np.median(np.abs(rate[fast]) / turns[fast])):.3g}")


def _rotary(speed: Seen) -> words.Unit | None:
    """The unit of a speed of turning; None for a feed."""
    unit = words.measure(speed.unit)
    return words.UNITS["rpm"] if unit is None else unit if unit.kind == "speed" else None


def _speed(speed: Seen, lead: float, others: Sequence[Seen], place: Seen | None) -> Guess:
    unit = words.measure(speed.unit) or words.UNITS["rpm"]
    scale = unit.scale / (lead if unit.kind == "feed" else 1.0)
    why = f"unit {speed.unit}" if speed.unit else "by its name, no unit: rpm"
    if unit.kind == "feed":
        why += f", a feed: rpm by a lead of {lead:g} mm"
    if place is not None and fit_of(speed, place) > FITS:
        why += f"; it is how fast {place.label} changes"
    most = round_up(_FASTER * scale * float(np.abs(speed.usual).max()) or 3000.0)
    return Guess("speed", "speed", (speed,), rule_of(speed, unit.unit, scale, -most, most), why, tuple(others))


def _place(place: Seen, others: Sequence[Seen]) -> Guess:
    unit = words.measure(place.unit) or words.UNITS["mm"]
    low, high = (unit.scale * end for end in place.usual)
    room = max(round_up((high - low) / 4), 10.0)
    why = (f"unit {place.unit}" if place.unit else "by its name, no unit: mm") + f", moves {high - low:.0f} mm"
    rule = rule_of(place, "mm", unit.scale, np.floor(low / 10) * 10 - room, np.ceil(high / 10) * 10 + room)
    return Guess("position", "position", (place,), rule, why, tuple(others))


def _is_place(one: Seen) -> bool:
    unit = words.measure(one.unit)
    if unit is None or unit.kind != "length":
        return bare(one) and words.says(one.label, words.POSITION)
    return unit.scale * one.width > _TRAVEL_MM or (
        words.says(one.label, words.POSITION)
        and not words.says(one.source, words.LENGTH)
        and unit.unit == "mm"
        and unit.scale >= 1.0
    )


def _levels(seen: Sequence[Seen], driven: bool) -> Iterator[Guess]:
    """The drive's current, and heaters in W or %; a power beside a drive is most often the drive's: recorded only."""
    for one in seen:
        kind, unit = _kind(one), words.measure(one.unit)
        heats = words.says(one.label, words.HEATER)
        if kind == "current" or (bare(one) and words.says(one.label, words.CURRENT)):
            most = round_up(_PEAK * float(np.abs(one.usual).max()) or 10.0)
            yield Guess("current", "current", (one,), rule_of(one, "A", 1.0, -most, most), _why(one))
        elif (
            heats
            or (kind == "power" and unit and unit.unit == "W")
            or (bare(one) and words.says(one.label, words.POWER))
        ):
            scale, name = (unit.scale, unit.unit) if unit else (1.0, _bare_level(one))
            most = round_up(1.5 * scale * float(one.value.max()) or 50.0)
            most = 100.0 if name == "%" and scale * one.value.max() <= 100.0 else 1.0 if name == "1" else most
            lo = min(0.0, -most if one.usual[0] < 0 else 0.0)
            role = "heater" if heats or not driven else "power"
            yield Guess(words.plain_name(one.label), role, (one,), rule_of(one, name, scale, lo, most), _why(one))


def _bare_level(one: Seen) -> str:
    """The unit of a heater without one: on and off, W, or %."""
    return "1" if {*one.value} <= {0.0, 1.0} else "%" if one.usual[1] > _MOST_W else "W"


def _why(one: Seen) -> str:
    return f"unit {one.unit}" if one.unit else "by its name"


def round_up(value: float) -> float:
    """The next number of one digit, or one and a half, above it."""
    if not value:
        return 0.0
    ten = 10.0 ** np.floor(np.log10(abs(value)))
    return float(next(step for step in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if step * ten >= value * (1 - 1e-9)) * ten)


def rule_of(one: Seen, unit: str, scale: float, lo: float, hi: float) -> Signal:
    scale = float(f"{scale:.10g}")
    return Signal(*one.place, unit, scale, lo=float(lo), hi=float(hi))


def _kind(one: Seen) -> str:
    unit = words.measure(one.unit)
    return unit.kind if unit else ""


def bare(one: Seen) -> bool:
    """Whether it may be a measured value though it has no unit: no state, no counter."""
    return one.unit == "" and not one.texts and not words.says(one.label, words.COUNTED)
