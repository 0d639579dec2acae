"""Whether temperatures as a whole can be what rig.toml says: in another unit they are all wrong in the same way."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from drivers.decode.condense import Readings
from drivers.frames import Array, Tally
from estimator.errors import InputError
from estimator.rig import Rig

_KELVIN = (220.0, 480.0)  # what a machine has in K
_HOT_C = 55.0  # 13 degC in degF


def admit(
    path: Path, rig: Rig, cells: Mapping[str, Array], never: Mapping[str, str], read: Mapping[str, Readings]
) -> None:
    """No thermometer with a reading is an InputError that shows what they have instead.

    cells  numbers of each column, (n,)     never  of those without any, what stands there     read  what can be used
    """
    names = [name for name in rig.thermometers if name in cells]
    if not names or any(len(read[name].value) for name in names):
        return
    if wrong := [never[name] for name in names if name in never]:
        raise InputError(f"{path}: no thermometer was ever read: {wrong[0]}")
    for name in names:
        known, rule = cells[name][np.isfinite(cells[name])], rig.channels[name]
        if len(known):
            low, high = float(known.min()), float(known.max())
            unit = '; in K? Say unit = "K" in rig.toml' if _KELVIN[0] < low and high < _KELVIN[1] else ""
            outside = f"{low:g} ... {high:g}, outside {rule.lo:g} ... {rule.hi:g} {rule.unit}"
            raise InputError(f"{path}: no thermometer was ever read: {name} has {outside}{unit}")


def hot(rig: Rig, read: Mapping[str, Readings], tally: Tally) -> None:
    """A note where everything, the air too, begins as hot as it would be in degF."""
    signals = {**rig.channels, **rig.inputs}
    first = [one.value[0] for name, one in read.items() if signals[name].unit == "degC" and len(one.value)]
    if len(first) > 2 and min(first) > _HOT_C:
        tally.note(f"all temperatures begin at {min(first):.0f} degC or more: in degF? Then scale and offset convert")
