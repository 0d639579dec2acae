"""Machine number N: the paper's for 0, else every number drawn by N in its range and a few laws of another form."""

import math
from collections.abc import Iterator
from dataclasses import asdict, fields, is_dataclass, replace
from functools import cache
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.machine.geometry import OMEGA_20, OUTER_RADIUS_M, SCREW_MM, SPAN_MM
from drivers.virtual_rig.machine.screw import AREA_M2
from drivers.virtual_rig.population.constants import CHANNELS, PAPER, Air, Anchor, Machine, Nut, Range, Sensors

SLOWEST, REACHED_UM = 0.125, 50.0  # every machine must reach 50 um at 2.5 m/min, as the paper's does
FINE_GAIN, COARSE_GAIN = 0.003, 0.007
SHORTEST_LAG_S, LONGEST_LAG_S = 3.0, 15.0
RADIATION = 5.8  # W/(m2 K), 4 sigma T^3 at 295 K
AROUND_M = 2.0 * math.pi * OUTER_RADIUS_M


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
    "two_lump_nut": Law(0.4, "screw - balls' body - flange - table", "screw - nut - table"),
    "growing_still_air": Law(0.4, "h = still (|T - T_air| / rise)^growth of each place", "h = still"),
    "radiating_surface": Law(0.6, "radiates with its emissivity", "no radiation"),
    "thinning_friction": Law(0.35, "torque falls by 0.5 - 1.5 %/K", "torque independent of temperature"),
    "churning_grease": Law(0.3, "3 - 12 % more nut torque after a rest", "no churning"),
    "coarse_gains": Law(0.25, "channel gains scatter by 0.7 %", "channel gains scatter by 0.3 % (paper: exact)"),
}


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


def steady_growth_um(one: Machine, speed: float) -> float:
    """Growth of the measured span at last; `speed` against 20 m/min. A fifth off at most at 2.5 m/min.

    X = rho L sum q / sum g, all of the screw equally warm but for the seats, which a fin's 2 sqrt(h P k A) joins to it
    """
    h = _film(one.air, speed)
    fin = 2.0 * math.sqrt(h * AROUND_M * one.screw.conductivity * AREA_M2)
    heat, away = _nut(one.nut, speed)
    away += h * AROUND_M * (SCREW_MM[1] - SCREW_MM[0] - one.nut.length) * 1e-3
    for support in (one.anchor, one.free):
        at_seat, from_seat = _bearing(support, speed)
        heat += at_seat * fin / (fin + from_seat)
        away += _series(fin, from_seat)
    return one.screw.expansion * (SPAN_MM[1] - SPAN_MM[0]) * 1e3 * heat / away


def _film(air: Air, speed: float) -> float:
    above = max(speed - air.threshold, 0.0) / (1.0 - air.threshold)
    return air.still + air.rotating * above**air.exponent + RADIATION * air.emissivity


def _nut(nut: Nut, speed: float) -> tuple[float, float]:
    power = nut.drag_torque * speed**nut.speed_exponent * speed * OMEGA_20
    out = _series(nut.to_table, nut.to_flange) if nut.to_flange else nut.to_table
    return _left(power, nut.into_screw, nut.contact, out)


def _bearing(support: Anchor, speed: float) -> tuple[float, float]:
    torque = support.load_torque * speed**support.power
    torque += support.viscous_torque * speed ** (support.power or 2.0 / 3.0)
    out = support.to_base + support.to_air
    out = _series(out, support.ring_to_bracket) if support.ring_to_bracket else out
    return _left(torque * speed * OMEGA_20, support.into_screw, support.contact, out)


def _left(power: float, share: float, contact: float, out: float) -> tuple[float, float]:
    """Heat that friction leaves in the screw (W), and the conductance from the screw through the body (W/K)"""
    return power * (share + (1.0 - share) * contact / (contact + out)), _series(contact, out)


def _series(*conductances: float) -> float:
    return 1.0 / sum(1.0 / g for g in conductances)
