"""What numbers and units may be: wide enough for any machine, too narrow for a slip of the pen."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from estimator.errors import SetupError
from estimator.model import Prior, Value
from estimator.rig import RAD_S, Channel, Rig, Signal
from estimator.rig_log import Csv
from estimator.screw import Bed, Nut, Screw, Support


@dataclass(frozen=True)
class Bound:
    """What a number may be: finite, from lo to hi, in a unit; `hint`: what is usual."""

    unit: str
    lo: float
    hi: float
    hint: str = ""

    def check(self, value: float, place: str) -> None:
        """A number outside is a SetupError that names the place."""
        if not self.lo <= value <= self.hi:
            bounds = f"{self.lo:g} ... {self.hi:g} {self.unit}".rstrip()
            raise SetupError(f"{place} is {brief(value)}, must be {bounds}{self.hint and '; ' + self.hint}")


PLACE = Bound("mm", -50_000.0, 50_000.0)
WIDTH = Bound("mm", 0.1, 10_000.0)
ANY = Bound("", -1e9, 1e9)
SIGNAL = {"scale": ANY, "offset": ANY, "lo": ANY, "hi": ANY}
BOUNDS: Mapping[type, Mapping[str, Bound]] = {
    Rig: {
        "tick_s": Bound("s", 0.01, 3600.0),
        "zero_C": Bound("degC", -60.0, 200.0, "20 is the reference temperature of lengths"),
        "zero_sd_K": Bound("K", 0.0, 10.0),
    },
    Screw: {
        "from_mm": PLACE,
        "to_mm": PLACE,
        "outer_mm": WIDTH,
        "bore_mm": Bound("mm", 0.0, 10_000.0),
        "lead_mm": Bound("mm", 0.01, 1000.0),
        "density": Bound("kg/m3", 100.0, 25_000.0, "steel has 7850"),
        "heat_capacity": Bound("J/(kg K)", 50.0, 10_000.0, "steel has 470"),
        "conductivity": Bound("W/(m K)", 0.05, 5000.0, "steel has 46"),
        "expansion": Bound("1/K", -2e-6, 5e-4, "steel has 12e-6"),
        "expansion_tolerance": Bound("", 0.0, 1.0, "it is a share of the expansion"),
        "span_from_mm": PLACE,
        "span_to_mm": PLACE,
        "reference_rpm": Bound("1/min", 10.0, 1e5),
        "cells": Bound("", 2, 2000, "2 to 5 mm each are enough"),
        "knots_mm": PLACE,
    },
    Nut: {"length_mm": WIDTH, "centre_mm": PLACE, "direction": Bound("", -1.0, 1.0, "1 or -1")},
    Bed: {
        "expansion": Bound("1/K", -2e-6, 5e-4, "cast iron has 11e-6, glass 8e-6"),
        "tolerance": Bound("", 0.0, 1.0, "it is a share of the expansion"),
    },
    Support: {"at_mm": PLACE, "width_mm": WIDTH},
    Csv: {"skip": Bound("lines", 0, 100_000)},
    Signal: SIGNAL,
    Channel: {**SIGNAL, "at_mm": PLACE},
    Value: {"sd": Bound("", 0.0, 1e12), "lo": ANY, "hi": ANY},
    Prior: {"value": ANY, "sd": Bound("", 1e-12, 1e12)},
}

TEMPERATURES = ("ambient", "base", "anchor_bracket", "free_bracket", "nut", "probe", "bar", "board")
UNITS: Mapping[str, tuple[str, ...]] = {  # of the inputs that the catalogue knows
    "position": ("mm",),
    "speed": tuple(RAD_S),
    "displacement_direct": ("um",),
    **dict.fromkeys(TEMPERATURES, ("degC",)),
}
TIME_UNITS = ("s", "ms", "us", "ns", "min", "h", "d")
COLDEST_C = -273.15
SHOWN = 60  # characters of a wrong value


def brief(value: Any) -> str:
    """A wrong value in an error: in one line, and not all of it where it is long."""
    try:
        text = repr(value)
    except ValueError:
        text = "a number of very many digits"
    return text if len(text) <= SHOWN else f"{text[:SHOWN]} ..."
