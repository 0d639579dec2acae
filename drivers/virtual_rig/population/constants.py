"""What one machine is: every number of its parts and sensors, with the range in which machines of its build differ.

The default of each is the paper's machine. A number that belongs to a law of another form (draw.LAWS) is drawn only on
machines that follow it; elsewhere it keeps the default, at which that law is invisible.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

CHANNELS = 15


class Range(NamedTuple):
    """Bounds between which a number is drawn evenly, or about the paper's value with `sd`; `law` it belongs to"""

    unit: str
    low: float
    high: float
    source: str
    law: str
    sd: float


def drawn(paper: float, unit: str, low: float, high: float, source: str, law: str = "", sd: float = 0.0) -> Any:
    """A number that differs from machine to machine."""
    return field(default=paper, metadata={"range": Range(unit, low, high, source, law, sd)})


@dataclass(frozen=True)
class Screw:
    """The steel."""

    conductivity: float = drawn(46.0, "W/(m K)", 42.0, 50.0, "textbooks, SCM420")
    volumetric_heat: float = drawn(3.6895e6, "J/(m3 K)", 3.616e6, 3.763e6, "7850 kg/m3, 470 J/(kg K), +-2 %")
    expansion: float = drawn(12.0e-6, "1/K", 11.2e-6, 12.3e-6, "measured in the paper: 12e-6", sd=0.1e-6)


@dataclass(frozen=True)
class Nut:
    """The nut; the places differ from the drawings by a little."""

    # N m from 2.2 kN of preload: 15 / 30 / 59 / 119 W at the four speeds if independent of speed
    drag_torque: float = drawn(0.68, "N m", 0.5, 0.9, "JIS B 1192: 0.31 / 0.63 / 0.94 at 1 / 2 / 3 kN")
    speed_exponent: float = drawn(0.0, "1", 0.0, 0.25, "n - 1 in heat ~ omega^n, 1.0 .. 1.25: the paper's times")
    into_screw: float = drawn(0.48, "1", 0.3, 0.7, "Machines 11(3) 408 (2023)")
    contact: float = drawn(3.0, "W/K", 1.5, 6.0, "Jungnickel 0.8 - 1.6 unsealed; more with grease, balls under load")
    contact_growth: float = drawn(0.0, "1/K", 0.01, 0.04, "preload by unequal expansion", "growing_contact")
    to_table: float = drawn(0.5, "W/K", 0.3, 1.0, "bolted flange and still air, computed")
    capacity: float = drawn(1200.0, "J/K", 1000.0, 2000.0, "computed, 2.2 - 4.3 kg")
    flange_share: float = drawn(0.0, "1", 0.3, 0.65, "flange and bracket against what balls run in", "two_lump_nut")
    to_flange: float = drawn(0.0, "W/K", 5.0, 30.0, "some cm of steel, and a bolted joint", "two_lump_nut")
    thinning: float = drawn(0.0, "1/K", 0.005, 0.015, "a fraction of Vogel's 0.031", "thinning_friction")
    churning: float = drawn(0.0, "1", 0.03, 0.12, "fresh grease, a fraction of 0.4", "churning_grease")
    planted_thinning: float = drawn(0.031, "1/K", 0.028, 0.035, "Vogel-Cameron, VG100 .. VG220")
    grease: float = drawn(20.0, "degC", 16.0, 27.0, "at which its torque is measured")
    churning_decay: float = drawn(600.0, "s", 300.0, 1500.0, "running-in of grease after a rest")
    churning_recovery: float = drawn(900.0, "s", 300.0, 1500.0, "running-in of grease after a rest")
    length: float = drawn(175.0, "mm", 172.0, 178.0, "paper; where balls carry")
    offset: float = drawn(0.0, "mm", -2.0, 2.0, "mounting")


@dataclass(frozen=True)
class Anchor:
    """The anchor bearing pair on its seat, and its housing; a ring of its own where housings are two lumps."""

    centre: float = drawn(889.0, "mm", 887.0, 891.0, "paper, channel 12; mounting")
    width: float = drawn(30.0, "mm", 21.0, 39.0, "inner rings and nut, +-30 %")
    load_torque: float = drawn(0.0745, "N m", 0.0447, 0.1043, "Palmgren's M1 of a pair, +-40 %")
    # grows with omega^(2/3); with M1: 2.5 / 6 / 15 / 41 W at the four speeds
    viscous_torque: float = drawn(0.1605, "N m", 0.0963, 0.2247, "Palmgren's M0 of a pair at 20 m/min, +-40 %")
    power: float = drawn(0.0, "1", 0.2, 0.5, "heat ~ omega^1.2 .. omega^1.5: greased pairs", "power_law_bearings")
    into_screw: float = drawn(0.65, "1", 0.45, 0.8, "inner ring against outer ring")
    contact: float = drawn(1.6, "W/K", 1.0, 3.0, "Jungnickel")
    to_base: float = drawn(8.0, "W/K", 5.0, 12.0, "bolted bracket, computed")
    to_air: float = drawn(0.5, "W/K", 0.3, 0.8, "bracket's surface, computed")
    capacity: float = drawn(3500.0, "J/K", 1800.0, 4600.0, "computed, 4 - 10 kg")
    ring_share: float = drawn(0.0, "1", 0.15, 0.4, "cartridge and rings against the bracket", "two_lump_housings")
    ring_to_bracket: float = drawn(0.0, "W/K", 8.0, 25.0, "flanged cartridge, computed", "two_lump_housings")
    thinning: float = drawn(0.0, "1/K", 0.005, 0.015, "a fraction of Palmgren's 0.042", "thinning_friction")
    planted_thinning: float = drawn(0.042, "1/K", 0.036, 0.048, "Palmgren")
    grease: float = drawn(20.0, "degC", 16.0, 27.0, "at which its torque is measured")


@dataclass(frozen=True)
class Free(Anchor):
    """The free bearing: smaller than the anchor."""

    centre: float = drawn(72.5, "mm", 70.5, 74.5, "paper, channel 2; mounting")
    width: float = drawn(20.0, "mm", 14.0, 26.0, "inner ring and nut, +-30 %")
    load_torque: float = drawn(0.7 * 0.0745, "N m", 0.0313, 0.073, "0.7 of the anchor's, +-40 %")
    viscous_torque: float = drawn(0.7 * 0.1605, "N m", 0.0674, 0.1573, "0.7 of the anchor's, +-40 %")
    contact: float = drawn(1.0, "W/K", 1.0, 2.5, "Jungnickel, one narrower ring")
    to_base: float = drawn(5.0, "W/K", 3.0, 8.0, "bolted bracket, computed")
    capacity: float = drawn(2200.0, "J/K", 1800.0, 4600.0, "computed, 4 - 10 kg")


@dataclass(frozen=True)
class Air:
    """The screw's surface."""

    still: float = drawn(3.6, "W/(m2 K)", 3.0, 5.3, "natural convection of a 40 mm rod, computed")
    growth: float = drawn(0.0, "1", 0.15, 0.33, "Nu ~ (Gr Pr)^(1/5 .. 1/3)", "growing_still_air")
    rise: float = drawn(5.0, "K", 3.0, 8.0, "above the air, for which `still` is computed", "growing_still_air")
    # on top of still air: together 10 / 13 / 19 / 29 at the four speeds, near Jungnickel's 6.8 / 11 / 18 / 29
    rotating: float = drawn(25.0, "W/(m2 K)", 18.0, 45.0, "at 20 m/min, Jungnickel .. Nu = 0.133 Re^(2/3) Pr^(1/3)")
    exponent: float = drawn(0.7, "1", 0.5, 0.8, "Jungnickel 0.7; correlations 0.5 .. 0.8")
    threshold: float = drawn(
        0.0, "1", 0.02, 0.1, "of omega_20, Anderson and Saunders' Re > 1.1 Gr^(1/2)", "late_rotation"
    )
    emissivity: float = drawn(0.0, "1", 0.2, 0.9, "machined .. greasy steel", "radiating_surface")


@dataclass(frozen=True)
class Sources:
    """Shape of planted sources of heat."""

    motor_width: float = drawn(40.0, "mm", 30.0, 60.0, "length in the coupling")
    local_width: float = drawn(30.0, "mm", 20.0, 60.0, "a hand's width at most")
    blast_fading: float = drawn(300.0, "s", 150.0, 600.0, "air after a stop")


@dataclass(frozen=True)
class Jig:
    """Slow bodies around the screw."""

    probe_follows: float = drawn(0.5, "1", 0.35, 0.65, "share of the seats' rise")
    probe_time: float = drawn(600.0, "s", 400.0, 900.0, "probe holders")
    bar_follows: float = drawn(0.4, "1", 0.25, 0.55, "share of the screw's mean rise")
    bar_time: float = drawn(1500.0, "s", 1000.0, 2200.0, "super-Invar bar")
    board_self_heating: float = drawn(6.0, "K", 4.0, 8.0, "above the air, at rest")
    board_turning: float = drawn(10.0, "K", 6.0, 14.0, "more at 20 m/min, from the rotary head")
    board_time: float = drawn(900.0, "s", 600.0, 1300.0, "board in its head")


@dataclass(frozen=True)
class Sensors:
    """Coefficients of the readings; without `lags` of its own (paper) each seed scatters the channels' lags."""

    probe_um_per_K: float = drawn(0.4, "um/K", 0.1, 0.5, "paper: up to +0.6 um in a run")
    bar_um_per_K: float = drawn(0.47, "um/K", 0.1, 0.7, "paper: up to -0.8 um in a run; Invar 0.1 - 0.75e-6 1/K")
    board_drift: float = drawn(0.003, "K/K", 0.001, 0.006, "within the paper's 0.05 K")
    depth: float = drawn(0.0, "1", 0.0, 0.3, "of the wall from bore layer to outer layer at the thermocouple's tip")
    lag: float = drawn(8.0, "s", 5.0, 13.0, "thermocouple pressed on steel, 3 - 15 s")
    lag_spread: float = drawn(2.0, "s", 0.5, 2.5, "between channels")
    lags: tuple[float, ...] = field(default=(), metadata={"unit": "s"})
    gains: tuple[float, ...] = field(default=(1.0,) * CHANNELS, metadata={"unit": "1"})


@dataclass(frozen=True)
class Machine:
    """One machine of the build: its number, the laws of another form that it follows (draw.LAWS), its numbers."""

    number: int = 0
    laws: tuple[str, ...] = ()
    screw: Screw = Screw()
    nut: Nut = Nut()
    anchor: Anchor = Anchor()
    free: Free = Free()
    air: Air = Air()
    sources: Sources = Sources()
    jig: Jig = Jig()
    sensors: Sensors = Sensors()


PAPER = Machine()
