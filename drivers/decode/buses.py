"""Of a log of several buses: which frames are the rig's, and their stamps on one clock.

Frames stand in a log in the order in which they came. Where the clocks of two buses differ by c, a frame of the one
that comes straight after one of the other is stamped c too late or too early: c lies between the most that the one
sort of pairs allows and the least that the other does.
"""

from collections.abc import Mapping

import numpy as np

from drivers.frames import Array, Frames, Index, Mask, Tally, falls_again_and_again, words_of
from estimator.errors import InputError

_TOLERATED_S = 0.05  # by which clocks may differ, and what one may drift by inside a block
_BLOCK = 200  # pairs of frames that show how far two clocks are apart
_FEWEST = 20
_BATCHES = 1.5  # of its length: for so long a bus may be silent around a batch
_APART_S = 3.0  # buses that are recorded together begin within some cycles of their messages


def chosen(frames: Frames, bus: str | int | None, name: str) -> Index:
    """Indices of the frames of the bus that rig.toml names; all where it names none."""
    if bus is None:
        return np.arange(len(frames))
    found = [k for k, name in enumerate(frames.buses) if _is(name, bus)]
    if not found:
        raise InputError(f"{name}: no frame of bus '{bus}', rig.toml's log.bus; it has {', '.join(frames.buses)}")
    return np.flatnonzero(np.isin(frames.bus, found))


def _is(name: str, bus: str | int) -> bool:
    """Whether a bus of a log is the one that rig.toml means: by its name, or by its number in the log."""
    named, _, channel = name.partition(" = channel ")
    number = channel or named.lstrip("abcdefghijklmnopqrstuvwxyz_-")
    return bus in (name, named) if isinstance(bus, str) else number == str(bus)


def of_the_rig(frames: Frames, wanted: Mapping[int, str], name: str, tally: Tally) -> Index:
    """Indices of the frames of those buses that carry what the rig needs (`wanted`: names by key).

    A message that comes on two buses is an InputError: they are two machines, and rig.toml has to say which is the rig.
    """
    on = {key: np.unique(frames.bus[frames.key == key]) for key in wanted}
    if twice := [key for key, buses in on.items() if len(buses) > 1]:
        names = " and ".join(sorted({frames.buses[k] for key in twice for k in on[key]}))
        what = f"{wanted[twice[0]]} (0x{twice[0] >> 1:X})" + (f" and {len(twice) - 1} more" if len(twice) > 1 else "")
        first = frames.buses[on[twice[0]][0]].partition(" = ")[0]
        fix = f'name the rig\'s, such as bus = "{first}", under [log] in rig.toml'
        raise InputError(f"{name}: {what} come on the buses {names}, two machines: {fix}")
    used = {int(k) for buses in on.values() for k in buses}
    if not used:
        return np.arange(len(frames))
    if len(used) > 1:
        tally.note(f"the rig's messages come on {' and '.join(sorted(frames.buses[k] for k in used))}")
    ours = np.isin(frames.bus, sorted(used))
    for k in set(np.unique(frames.bus[~ours]).tolist()):
        tally.skip(f"on {frames.buses[k]}, where nothing of the rig is", np.count_nonzero(frames.bus == k))
    return np.flatnonzero(ours)


def on_one_clock(frames: Frames, name: str, tally: Tally) -> Array:
    """Stamps of all frames, (n,) s, on the clock of the first frame's bus.

    Clocks of which one runs unsteadily against the other are an InputError.
    """
    first, *others = sorted(np.unique(frames.bus).tolist(), key=lambda bus: int(np.argmax(frames.bus == bus))) or [0]
    time = frames.time.copy() if others else frames.time
    for bus in others:
        index = np.flatnonzero((frames.bus == first) | (frames.bus == bus))
        is_other = frames.bus[index] == bus
        names = f"{frames.buses[bus]} and {frames.buses[first]}"
        lead = _lead(frames.time[index], is_other, f"{name}: the clocks of {names}")
        if lead is None:
            continue
        time[index[is_other]] -= lead
        low, high = sorted((abs(float(lead.min())), abs(float(lead.max()))))
        by = f"{low:.2f} s" if high - low < _TOLERATED_S else f"{low:.2f} to {high:.2f} s"
        tally.note(f"the clocks of {names} are {by} apart: both on that of {frames.buses[first]}")
    return time


def _lead(time: Array, is_other: Mask, what: str) -> Array | None:
    """By how much the other bus's clock is ahead at each of its frames, (m,) s; None where both run alike."""
    pairs = np.flatnonzero(is_other[1:] != is_other[:-1]) + 1
    step, to_other = np.diff(time)[pairs - 1], is_other[pairs]
    most, least = step[to_other], -step[~to_other]
    against = [np.mean(most < -_TOLERATED_S), np.mean(least > _TOLERATED_S)] if len(pairs) > _FEWEST else [0.0]
    if max(against) < 0.5:
        return None
    blocks = [slice(k, k + _BLOCK) for k in range(0, len(pairs) - _FEWEST, _BLOCK)]
    upper = np.array([np.min(step[b][to_other[b]], initial=np.inf) for b in blocks])
    lower = np.array([np.max(-step[b][~to_other[b]], initial=-np.inf) for b in blocks])
    if (good := lower - upper < _TOLERATED_S).mean() < 0.8:
        rise = all((np.diff(time[is_other == other]) >= 0).all() for other in (False, True))
        slack = _BATCHES * float(np.median(lower - upper)) + _TOLERATED_S
        if rise and np.median(upper) - slack < 0 < np.median(lower) + slack:
            return None  # one clock, whose frames came in batches
        raise InputError(f"{what} are apart by no steady time: record both with one clock, or the rig on one bus")
    middle, at = (lower + upper)[good] / 2, np.array([pairs[b].mean() for b in blocks])[good]
    if np.ptp(middle) < _TOLERATED_S:
        middle[:] = np.median(middle)
    return np.interp(np.flatnonzero(is_other), at, middle)


def told_once(frames: Frames, tick_s: float, tally: Tally) -> Index:
    """Indices of the frames without those that an earlier part of the log has, where its parts overlap."""
    part = np.cumsum(np.diff(frames.time, prepend=np.inf) < -tick_s / 2)
    if not len(part) or part[-1] == 1:
        return np.arange(len(frames))
    columns = (words_of(frames.data)[0], frames.dlc, frames.key, frames.bus, frames.time)
    order = np.lexsort(columns)
    alike = np.logical_and.reduce([np.diff(column[order]) == 0 for column in columns])
    again = order[1:][alike & (np.diff(part[order]) > 0)]
    if len(again):
        tally.note(f"{len(again)} frames are there twice: read once")
    return np.setdiff1d(np.arange(len(frames)), again)


def in_order(frames: Frames, tick_s: float, name: str, tally: Tally) -> Index:
    """Indices of the frames in the order of their stamps, where the log has its parts the wrong way round.

    So are the frames of several buses that came in batches: on each bus the stamps only rise. Parts are told from jumps
    of the clock by that one ends where another begins. Stamps that fall again and again are
    no clock, which is an InputError.
    """
    buses = np.unique(frames.bus)
    if len(buses) > 1 and all((np.diff(frames.time[frames.bus == bus]) >= 0).all() for bus in buses):
        return np.argsort(frames.time, kind="stable")
    steps, order = np.diff(frames.time), np.arange(len(frames))
    falls = int((steps < 0).sum())
    if falls > 2 * (steps > 0).sum():
        tally.note("newest frame first: turned round")
        return order[::-1]
    if falls_again_and_again(frames.time):
        raise InputError(
            f"{name}: its times fall {falls} times in {len(frames)} frames, as if each counted from the one before: "
            "no clock does; record them as counting from one zero"
        )
    starts = np.flatnonzero(np.diff(frames.time, prepend=np.inf) < -tick_s)
    ends = np.append(starts[1:], len(frames))
    by_start = np.argsort(frames.time[starts], kind="stable")
    gaps = frames.time[starts[by_start]][1:] - frames.time[ends[by_start] - 1][:-1]
    if len(starts) < 2 or not ((gaps > -tick_s / 2) & (gaps < 2 * tick_s)).all():
        return order
    tally.note(f"its {len(starts)} parts are the wrong way round: put in the order of their times")
    return np.concatenate([order[starts[k] : ends[k]] for k in by_start])


def together(frames: Frames, tally: Tally) -> None:
    """A note where one bus begins and ends later than another by the same: its clock may be ahead."""
    buses = [frames.time[frames.bus == bus] for bus in np.unique(frames.bus)]
    for k, other in enumerate(buses[1:], start=1):
        begins, ends = float(other[0] - buses[0][0]), float(other[-1] - buses[0][-1])
        if abs(begins) > _APART_S and abs(begins - ends) < _APART_S / 2:
            names = [frames.buses[bus] for bus in np.unique(frames.bus)]
            tally.doubt(f"{names[k]} begins and ends {begins:+.1f} s from {names[0]}: are their clocks apart by that?")
