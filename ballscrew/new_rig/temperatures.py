"""Which signals are temperatures, which of them are on the screw, and what the others are of."""

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from ballscrew.new_rig import words
from ballscrew.new_rig.seen import Guess, Seen
from ballscrew.new_rig.words import Unit
from estimator.errors import InputError
from estimator.rig import Signal

_KELVIN = (230.0, 450.0)
_COLDEST_C, _HOTTEST_C = -40.0, 150.0
_FINEST = 0.001  # degC, that a whole number may count
_FAMILY = 3  # of names that differ in a number only: they are of one kind whatever they are called
_QUICKEST = 2.0  # of a temperature, K from one reading to the next in the mean
THERMOMETER = "thermometer"


def temperatures(seen: Sequence[Seen]) -> list[Guess]:
    """All temperatures among these signals: the thermometers first, in the order of their numbers.

    Thermometers are the largest family of names that differ in a number only, of those called temperatures where there
    are such; without one, all that no other place is
    known of by their names. None is an InputError that says what there is.
    """
    found = {one.source: unit for one in seen if (unit := unit_of(one, seen))}
    warm = [one for one in seen if one.source in found]
    ours, why = _on_it(warm)
    if not ours:
        told = [f"{one.source} ({words.role_of(one.label)})" for one in warm] or [one.source for one in seen[:6]]
        raise InputError(
            f"no thermometer on a screw or a body among {', '.join(told)}: a rig needs one; a unit of degC or a name "
            "such as T1 says so"
        )
    names = _names(ours)
    on_it = [
        Guess(name, THERMOMETER, (one,), _rule(one, found[one.source]), f"{_said(found[one.source], one)}; {why}")
        for name, one in zip(names, ours, strict=True)
    ]
    return on_it + list(_others([one for one in warm if one not in ours], found, {*names}))


def _on_it(warm: Sequence[Seen]) -> tuple[list[Seen], str]:
    """Which temperatures are on the screw or a body, and why: first of those of no other place by their names."""
    plain = [one for one in warm if not words.role_of(one.label) and not words.says(one.label, words.WANTED)]
    for group in (plain, warm):
        counts = Counter(words.family(one.label) for one in group if words.number_in(one.label))
        called = Counter(
            {name: n for name, n in counts.items() if n >= _FAMILY and words.says(name, words.TEMPERATURE)}
        )
        name, most = (called or counts).most_common(1)[0] if counts else ("", 0)
        if most >= _FAMILY:
            alike = [one for one in group if words.family(one.label) == name]
            return sorted(alike, key=lambda one: words.number_in(one.label)), f"{most} named {name}"
        if plain:
            return plain, "no other by its name"
    return [], ""


def _others(warm: Sequence[Seen], found: dict[str, Unit], taken: set[str]) -> Iterator[Guess]:
    """Temperatures of the surroundings, one of a role; what has none keeps its name."""
    roles = {one.source: words.role_of(one.label) for one in warm}
    first: dict[str, Seen] = {}
    for one in warm:
        first.setdefault(roles[one.source] or one.source, one)
    for one in warm:
        role = roles[one.source]
        is_first = first.get(role) is one
        why = f"{_said(found[one.source], one)}; {'by its name' if is_first else 'for effects of your own'}"
        name = role if is_first else _free(one, taken)
        taken.add(name)
        also = tuple(other for other in warm if is_first and other is not one and roles[other.source] == role)
        yield Guess(name, role if is_first else "temperature", (one,), _rule(one, found[one.source]), why, also)


def _free(one: Seen, taken: set[str]) -> str:
    label = words.plain_name(one.label)
    return label if label not in taken and label not in words.ROLES else f"{label}_input"


def _names(ours: Sequence[Seen]) -> list[str]:
    """Names of channels: those of their signals, with the message where two messages have the same."""
    twice = Counter(one.label for one in ours)
    return [(one.label if twice[one.label] < 2 else f"{one.message}_{one.label}").strip()[:64] for one in ours]


def unit_of(one: Seen, seen: Sequence[Seen]) -> Unit | None:
    """The unit of a temperature, as it is said or as its numbers can only be; None for what is none."""
    said = words.measure(one.unit)
    if said is not None:
        return _by_size(one, said) if said.kind == "temperature" else None
    if (
        one.unit
        or words.says(one.label, words.TIMES)
        or one.texts.keys() & set(np.unique(one.raw[:100]).tolist())
        or not _slow(one)
    ):
        return None
    named = words.says(one.source, words.TEMPERATURE) or bool(words.role_of(one.label))
    low, high = one.usual
    alike = sum(words.family(other.label) == words.family(one.label) for other in seen)
    if not named and (alike < _FAMILY or not words.number_in(one.label) or words.says(one.label, words.COUNTED)):
        return None
    if low > _COLDEST_C and high < _HOTTEST_C and (named or high > low):
        return words.UNITS["degC"]
    return _by_size(one, words.UNITS["degC"]) if named and high < _HOTTEST_C / _FINEST else None


def _by_size(one: Seen, said: Unit) -> Unit:
    """The unit, mended where the numbers cannot be in it: K, tenths or hundredths of a degC."""
    low, high = one.usual
    if said.unit != "degC" or said.offset or high < _HOTTEST_C:
        return said
    if _KELVIN[0] < low and high < _KELVIN[1]:
        return words.UNITS["K"]
    scale = next((scale for scale in (0.1, 0.01, _FINEST) if high * scale < _HOTTEST_C), 1.0)
    return Unit("temperature", "degC", scale)


def _slow(one: Seen) -> bool:
    """Whether it changes as slowly as a temperature."""
    steps = np.abs(np.diff(one.value))
    return len(steps) == 0 or float(steps.mean()) < _QUICKEST * max(1.0, float(np.abs(one.value).max()) / _HOTTEST_C)


def _said(unit: Unit, one: Seen) -> str:
    if words.measure(one.unit) == unit:
        return f"unit {one.unit}"
    written = "K" if unit.unit == "K" else "degC" if unit.scale == 1.0 else f"{unit.scale:g} degC"
    low, high = one.usual
    return f"{'unit ' + one.unit if one.unit else 'no unit'}, {low:.4g} ... {high:.4g} can be {written}"


def _rule(one: Seen, unit: Unit) -> Signal:
    return Signal(*one.place, unit.unit, unit.scale, unit.offset)
