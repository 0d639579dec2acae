"""Whether temperatures as a whole can be what rig.toml says: in another unit they are all wrong in the same way."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from drivers.decode.condense import Readings
from drivers.frames import Array, Tally
from estimator.errors import InputError
from estimator.record import POWER_ON_C
from estimator.rig import Rig

_KELVIN = (220.0, 480.0)  # what a machine has in K
_COLD_C, _HOT_C = 8.0, 55.0  # 13 degC in degF
_ALIKE_K = 5.0
_PARTS = {0.1: "tenths", 0.01: "hundredths", 0.001: "thousandths"}  # of a degree


def admit(
    path: Path, rig: Rig, cells: Mapping[str, Array], never: Mapping[str, str], read: Mapping[str, Readings]
) -> None:
    """No thermometer with a reading, or all of them hot and most too hot, is an InputError that shows what they have.

    cells  numbers of each column, (n,)     never  of those without any, what stands there     read  what can be used
    """
    names = [name for name in rig.thermometers if name in cells]
    ever = any(len(read[name].value) for name in names)
    if not names or (ever and not _too_hot(rig, names, cells)):
        return
    if wrong := [never[name] for name in names if name in never]:
        raise InputError(f"{path}: no thermometer was ever read: {wrong[0]}")
    for name in names:
        known, rule = cells[name][np.isfinite(cells[name])], rig.channels[name]
        if len(known):
            low, high = float(known.min()), float(known.max())
            outside = f"{low:g} ... {high:g}, outside {rule.lo:g} ... {rule.hi:g} {rule.unit}"
            what = f"{'most thermometers are too hot' if ever else 'no thermometer was ever read'}: {name} has"
            raise InputError(f"{path}: {what} {outside}{_perhaps(low, high)}")


def _too_hot(rig: Rig, names: Sequence[str], cells: Mapping[str, Array]) -> bool:
    """Whether all are hot, most of them usually hotter than they can be: those that can may be low, in other units."""
    signals = [rig.channels[name] for name in names if np.isfinite(cells[name]).any()]
    usual = [np.nanmedian(cells[name]) for name in names if np.isfinite(cells[name]).any()]
    value = np.array([one.scale * middle + one.offset for one, middle in zip(signals, usual)])
    return bool((value > _HOT_C).all() and np.mean(value > [one.hi for one in signals]) > 0.5)


def _perhaps(low: float, high: float) -> str:
    """What these numbers would be temperatures in."""
    units = ['in K? Say unit = "K"'] if _KELVIN[0] < low and high < _KELVIN[1] else []
    for scale, part in _PARTS.items():
        if low * scale > _COLD_C and high * scale < _HOT_C:
            units.append(f"in {part} of a degree? Say scale = {scale:g}")
    return f"; {'. Or '.join(units)} in rig.toml" if units else ""


def hot(rig: Rig, read: Mapping[str, Readings], tally: Tally) -> None:
    """A note where all thermometers begin as hot as in degF, and the air too, or all alike: what is hot is not even."""
    signals = {**rig.channels, **rig.inputs}
    known = {name: one.value[~np.isin(one.value, POWER_ON_C)] for name, one in read.items()}
    first = {name: value[0] for name, value in known.items() if signals[name].unit == "degC" and len(value)}
    on_it = [value for name, value in first.items() if name in rig.thermometers]
    what, hot = (
        ("temperatures", [*first.values()]) if min(first.values(), default=0.0) > _HOT_C else ("thermometers", on_it)
    )
    if len(hot) > 2 and min(hot) > _HOT_C and (hot is not on_it or np.ptp(hot) < _ALIKE_K):
        tally.doubt(f"all {what} begin at {min(hot):.0f} degC or more: in degF? Then scale and offset convert")
