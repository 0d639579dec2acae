"""Machine number N: the paper's for 0, else every number drawn by N in its range and a few laws of another form."""

from collections.abc import Iterator
from dataclasses import asdict, fields, is_dataclass, replace
from functools import cache
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.population.constants import CHANNELS, PAPER, Machine, Range, Sensors
from drivers.virtual_rig.population.steady import steady_growth_um


class Law(NamedTuple):
    """A form that a share of the machines have, and what the others have (the paper's machine among them)"""

    share: float
    this: str
    usual: str


LAWS = {
    "power_law_bearings": Law(0.35, "M = (M1 + M0) speed^power", "M = M1 + M0 speed^(2/3), Palmgren"),
    "late_rotation": Law(
        0.3, "h = still + rotating ((speed - threshold) / (1 - threshold))^m above it", "h = still + rotating speed^m"
    ),
    "growing_contact": Law(0.35, "g = contact (1 + contact_growth |T_nut - T_screw|)", "g = contact"),
    "two_lump_housings": Law(0.4, "seat - ring - bracket - base", "seat - housing - base"),
    "radiating_surface": Law(0.6, "radiates with its emissivity", "no radiation"),
    "thinning_friction": Law(0.35, "torque falls by 0.5 - 1.5 %/K", "torque independent of temperature"),
    "churning_grease": Law(0.3, "3 - 12 % more nut torque after a rest", "no churning"),
    "coarse_gains": Law(0.25, "channel gains scatter by 0.7 %", "channel gains scatter by 0.3 % (paper: exact)"),
}
SLOWEST, REACHED_UM = 0.125, 50.0  # every machine must reach 50 um at 2.5 m/min, as the paper's does
FINE_GAIN, COARSE_GAIN = 0.003, 0.007
SHORTEST_LAG_S, LONGEST_LAG_S = 3.0, 15.0


@cache
def machine(number: int) -> Machine:
    """The same number is the same machine, 0 the paper's; `constants` has the ranges.

    Its numbers are drawn again until it can follow the protocol; the laws it follows are drawn once.
    """
    if number < 0:
        raise ValueError(f"machine {number}: machines are numbered from 0, the paper's, on")
    if number == 0:
        return PAPER
    laws = tuple(name for name, law in LAWS.items() if dice(number, "law", name).random() < law.share)
    return next(one for one in _built(number, laws) if steady_growth_um(one, SLOWEST) > REACHED_UM)


def _built(number: int, laws: tuple[str, ...]) -> Iterator[Machine]:
    """One attempt after the other."""
    for attempt in count():
        again = ("again",) * attempt
        parts = {part: _drawn(number, part, paper, laws, again) for part, paper in _parts(PAPER).items()}
        yield _with_channels(Machine(number, laws, **parts))


def _with_channels(one: Machine) -> Machine:
    """Its channels with gains and lags of their own."""
    sd = COARSE_GAIN if "coarse_gains" in one.laws else FINE_GAIN
    gains = 1.0 + sd * dice(one.number, "gains").standard_normal(CHANNELS)
    lags = scattered_lags(one.sensors, dice(one.number, "lags"))
    return replace(one, sensors=replace(one.sensors, gains=tuple(gains.tolist()), lags=tuple(lags.tolist())))


def scattered_lags(sensors: Sensors, draw: np.random.Generator) -> np.ndarray:
    """Lag of each channel, s: (15,); within two spreads of the mean and within 3 .. 15 s"""
    lag, reach = sensors.lag, 2.0 * sensors.lag_spread
    scatter = lag + sensors.lag_spread * draw.standard_normal(CHANNELS)
    return np.clip(scatter, max(lag - reach, SHORTEST_LAG_S), min(lag + reach, LONGEST_LAG_S))


def described(one: Machine) -> dict[str, Any]:
    """A machine as JSON holds it: number, which laws hold and their form, constants by part, unit of each constant."""
    parts = _parts(one)
    return {
        "machine": one.number,
        "laws": {name: _law(law, name in one.laws) for name, law in LAWS.items()},
        "constants": {part: asdict(numbers) for part, numbers in parts.items()},
        "units": {part: {f.name: _unit(f.metadata) for f in fields(numbers)} for part, numbers in parts.items()},
    }


def _parts(one: Machine) -> dict[str, Any]:
    values = {f.name: getattr(one, f.name) for f in fields(one)}
    return {name: value for name, value in values.items() if is_dataclass(value)}


def _law(law: Law, holds: bool) -> dict[str, Any]:
    return {"holds": holds, "form": law.this if holds else law.usual}


def _unit(metadata: Any) -> str:
    return metadata["range"].unit if "range" in metadata else metadata["unit"]


def _drawn(number: int, part: str, paper: Any, laws: tuple[str, ...], again: tuple[str, ...]) -> Any:
    """One part with every number of its own drawn, each by a stream of its own: a new one leaves the others alone."""
    ranges = {f.name: f.metadata["range"] for f in fields(paper) if "range" in f.metadata}
    return replace(paper, **{
        name: _number(dice(number, part, name, *again), getattr(paper, name), span)
        for name, span in ranges.items() if not span.law or span.law in laws
    })  # fmt: skip


def _number(draw: np.random.Generator, paper: float, span: Range) -> float:
    if not span.sd:
        return float(draw.uniform(span.low, span.high))
    tries = paper + span.sd * draw.standard_normal(100)
    return float(tries[(span.low <= tries) & (tries <= span.high)][0])
