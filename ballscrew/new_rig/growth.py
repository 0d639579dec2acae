"""Which signals read how much the screw has grown."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ballscrew.new_rig import words
from ballscrew.new_rig.drive import FITS, bare, round_up, rule_of
from ballscrew.new_rig.seen import Guess, Seen
from drivers.frames import Array

STEEL_UM_K = 12.0  # a metre of steel
_WARM_K, _FEW = 1.0, 10  # a warming, and readings, that tell something
_GROWTH_MM = 2.0  # a growth is less, and a position moves by more
_COUNTS, _FEWEST = 0.95, 3  # share of the steps of a counter that are one; numbers that are no mere switch
_CLEAR_UM, _STEPS = 1.0, 20  # a growth that no reading misses, in um and in steps of its resolution
_VALID = ("ok", "valid", "good", "normal", "gueltig")


def growth(seen: Sequence[Seen], drive: Sequence[Guess], warmth: tuple[Array, Array]) -> Iterator[Guess]:
    """The growth read while the screw turns, and that at rest where there are two; a pair of probes is averaged.

    drive   what is known to be something else     warmth  time (n,) s and mean rise (n,) of the thermometers
    """
    taken = {one.source for guess in drive for one in guess.seen}
    lengths = [one for one in seen if one.source not in taken and _is_growth(one)]
    groups = [tuple(lengths[k] for k in at) for at in _together(lengths)]
    if not groups:
        return
    speed = next((guess for guess in drive if guess.name == "speed"), None)
    groups.sort(key=lambda group: (words.says(group[0].source, words.AT_REST), -_share_driving(group[0], speed)))
    first, *rest = groups
    direct = next((group for group in rest if words.says(group[0].source, words.AT_REST)), None)
    direct = direct or (rest[0] if rest and speed else None)
    left = tuple(one for group in rest if group is not direct for one in group)
    way = _way(first, warmth)
    yield _growth("displacement", first, seen, way, left, warmth)
    if direct is not None:
        yield _growth("displacement_direct", direct, seen, way if len(direct) == len(first) else _Way(), (), warmth)


class _Way(NamedTuple):
    """How signals of one message become a growth: which of them, their sum times what, and why."""

    which: tuple[int, ...] = (0,)
    scale: float = 1.0
    why: str = ""


_WAYS = (
    _Way(),
    _Way((1,)),
    _Way((0, 1), 0.5, "the mean of two"),
    _Way((0, 1), 1.0, "the sum of two"),
)


def _is_growth(one: Seen) -> bool:
    unit = words.measure(one.unit)
    if unit is None or unit.kind != "length":
        return bare(one) and words.says(one.source, words.LENGTH)
    return unit.scale * one.width < _GROWTH_MM and (unit.scale < 1.0 or words.says(one.source, words.LENGTH))


def _together(lengths: Sequence[Seen]) -> Iterator[tuple[int, ...]]:
    """Two of one message that always come together are of one reading: of two probes, or of the screw's two ends."""
    left = list(range(len(lengths)))
    while left:
        one = left.pop(0)
        pair = next((other for other in left if _one_reading(lengths[one], lengths[other])), None)
        if pair is not None:
            left.remove(pair)
        yield (one, pair) if pair is not None else (one,)


def _one_reading(one: Seen, other: Seen) -> bool:
    alike = one.message == other.message != "" and one.unit == other.unit
    return alike and np.array_equal(one.time, other.time)


def _way(group: tuple[Seen, ...], warmth: tuple[Array, Array]) -> _Way:
    """What of them grows most nearly as a metre of steel does with its temperature; turned round where they shrink."""
    warm = _from_the_mean(np.interp(group[0].time, *warmth), group[0].parts)
    if np.ptp(warm) < _WARM_K or len(warm) < _FEW:
        return _Way()
    unit = words.measure(group[0].unit)
    um = unit.scale * 1e3 if unit else 1.0
    found = []
    for way in _WAYS:
        if max(way.which) < len(group):
            total = np.sum([group[k].value for k in way.which], axis=0)
            value = _from_the_mean(total * way.scale * um, group[0].parts)
            slope = float(warm @ value / (warm @ warm))
            fit = slope * float(np.std(warm)) / max(float(np.std(value)), 1e-9)
            found.append((abs(np.log(max(abs(slope), 1e-9) / STEEL_UM_K)), way, slope, fit))
    _, way, slope, fit = min(found, key=lambda one: one[0])
    why = f"{way.why}, which grows by {slope:.2g} um/K" if way.why else way.why
    if fit < -FITS:
        return _Way(way.which, -way.scale, ", ".join(filter(None, (why, "turned round: it falls as the screw warms"))))
    return _Way(way.which, way.scale, why)


def _from_the_mean(values: Array, parts: Sequence[int]) -> Array:
    """Values less their mean in each recording: the zero of each is its own."""
    return np.concatenate([part - part.mean() for part in np.split(values, parts[1:]) if len(part)])


def _share_driving(one: Seen, speed: Guess | None) -> float:
    """Which share of its readings came while the screw turned."""
    if speed is None:
        return 0.0
    return float(np.mean(np.abs(np.interp(one.time, speed.time, speed.value)) > 0.01 * np.abs(speed.value).max()))


def _growth(
    name: str,
    group: tuple[Seen, ...],
    seen: Sequence[Seen],
    way: _Way,
    left: tuple[Seen, ...],
    warmth: tuple[Array, Array],
) -> Guess:
    unit = words.measure(group[0].unit)
    used = tuple(group[k] for k in way.which)
    scale = way.scale * (unit.scale * 1e3 if unit else 1.0)
    said = f"unit {group[0].unit}" if unit else "by its name, no unit: um"
    most = max(1000.0, round_up(10 * abs(scale) * max(float(np.abs(one.usual).max()) for one in used)))
    beside = [one for one in seen if one.message and one.message == group[0].message and one not in group]
    counter = next((one.source for one in beside if counts_up(one.raw)), None)
    repeats = counter is None and held(scale * used[0].value, np.interp(used[0].time, *warmth))
    rule = replace(
        rule_of(used[0], "um", scale, -most, most),
        fresh=used[0].source if repeats else counter,
        valid=next((f"{one.source} = {text}" for one in beside if (text := ok_text(one))), None),
    )
    rule = replace(rule, signal=tuple(one.source for one in used) if len(used) > 1 else rule.signal)
    also = (*(one for one in group if one not in used), *left)
    repeated = "the last reading is repeated until there is a new one" if repeats else ""
    return Guess(name, name, used, rule, ", ".join(filter(None, (said, way.why, repeated))), also)


def held(growth_um: Array, warm: Array) -> bool:
    """Whether a growth is repeated until there is a new reading: it stays while the screw grows by many of its steps.

    growth_um  (n,) readings     warm  (n,) K, mean rise of the thermometers with them
    """
    if not len(steps := np.abs(np.diff(growth_um))) or not steps.any():
        return False
    least = max(_CLEAR_UM, _STEPS * float(steps[steps > 0].min()))
    first = np.flatnonzero(np.concatenate(([True], steps > 0)))
    last = np.append(first[1:], len(growth_um)) - 1
    grown = STEEL_UM_K * np.abs(warm[last] - warm[first])
    return bool(np.any(grown[last - first >= _FEW] > least))


def counts_up(raw: Array) -> bool:
    """Whether numbers of the wire count up by one where they change, and start again."""
    steps = np.diff(raw.astype(np.int64))
    steps = steps[steps != 0]
    modulus = int(raw.max(initial=0)) + 1
    return len(steps) > _FEW and modulus > _FEWEST and bool(np.mean(steps % modulus == 1) > _COUNTS)


def ok_text(one: Seen) -> str:
    """The text of a state that says that all is well, where it is what comes most; "" for what is no such state."""
    good = [text for text in one.texts.values() if text.casefold() in _VALID]
    if not good or not len(one.raw):
        return ""
    numbers, counts = np.unique(one.raw, return_counts=True)
    return good[0] if one.texts.get(int(numbers[counts.argmax()])) == good[0] else ""
