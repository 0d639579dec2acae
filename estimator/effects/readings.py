"""What thermometers make of the temperatures: lag, offset, gain, and drift of their circuit board."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

from estimator.effect import Effect, Param
from estimator.inputs.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import SCREW, START, Lag, Read, Spot, Term


class Thermometers(Effect):
    """Thermometers press on the bore, follow it with a lag, and shift with the temperature of their circuit board.

    y = s + board (T_board - T_board(0)) + zero,   tau ds/dt = T(x) - s

    zero_sd    thermometers differ by a constant each, ...
    zero_walk  ... that changes slowly with each one's own drift
    gain_sd    each shows a little more or less of its rise than is true
    lag_sd     each one's lag is a little longer or shorter than tau
    tau        holds the bore's delay behind the mean of the section too, about 2 s
    bore       heat enters outside and the wall of the bore is the cooler for it, where it goes on along the axis: 1 for
               thermometers at the wall, 0 for such as read the mean of the section
    lag_noise  lags differ between thermometers by a quarter, and stay wrong for as long as a drive lasts: the filter
               weighs a reading as if its lag scattered by this much
    """

    sd = Param(0.022, "K", lo=0.0005, hi=5.0, fixed=True, source="0.02 K scatter and 0.01 K steps")
    trace = "None of its own: without it no temperature is read."
    tau = Param(8.0, "s", lo=0.0, hi=120.0, null=0.0, sd=3.0, source="3 - 15 s")
    lag_noise = Param(
        1.0, "1", lo=0.0, hi=20.0, fixed=True, source="by coverage on simulated runs; lags spread by a quarter"
    )
    zero_sd = Param(0.015, "K", lo=0.0, hi=1.0, fixed=True, source="0.05 K between 15 channels after warm-up")
    zero_walk = Param(0.0001, "K/sqrt(s)", lo=0.0, hi=0.1, fixed=True, source="0.006 K in an hour")
    gain_sd = Param(0.004, "1", lo=0.0, hi=0.1, fixed=True, source="0.4 % of the temperature, class 1 of IEC 60584")
    lag_sd = Param(0.25, "1", lo=0.0, hi=2.0, fixed=True, source="how hard each is pressed on: a quarter")
    board = Param(0.0, "K/K", lo=-0.3, hi=0.3, null=0.0, sd=0.003, fixed=True, source="0.03 K per 10 K")
    bore = Param(
        1.0, "1", lo=0.0, hi=2.0, null=0.0, sd=0.2, fixed=True, source="a tip may be let into the wall by a third of it"
    )

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        offset, deep = p.board * u.rise("board"), _deep(p.bore, rig)
        for name in rig.thermometers:
            channel = rig.channels[name]
            if channel.at_mm is not None:
                yield Read(
                    name, {SCREW: Spot(channel.at_mm, deep=deep)}, p.sd, offset, p.zero_sd, p.zero_walk, p.gain_sd
                )
                yield Lag(name, p.tau, p.lag_noise, p.lag_sd)
            elif channel.node is not None:
                yield Read(name, {channel.node: 1.0}, p.sd, offset, p.zero_sd, p.zero_walk, p.gain_sd)


class SensorLag(Effect):
    """Thermometers follow the screw more slowly than the effect `thermometers` says.

    (tau_thermometers + tau) dy/dt = T(x) - y
    """

    trace = "Only while temperatures change: follows dT/dt, gone within a minute of a stop."
    tau = Param(15.0, "s", lo=0.0, hi=120.0, null=0.0, source="3 - 15 s where they press on the bore, more where not")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        yield from (Lag(name, p.tau) for name in rig.thermometers)


class BoardDrift(Effect):
    """All thermometers shift with the temperature of their circuit board, more than their own drift says.

    y = s + drift (T_board - T_board(0))
    """

    trace = "All thermometers alike, in step with the board's temperature; the elongation is right."
    drift = Param(0.01, "K/K", lo=-0.3, hi=0.3, null=0.0, source="up to 0.5 K in 10 K for a cheap reference junction")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        u["board"]
        yield from (Read(name, {}, 0.0, p.drift * u.rise("board")) for name in rig.thermometers)


class ChannelOffset(Effect):
    """One thermometer jumps when the screw first turns, and stays off by a constant.

    y = s + offset from the first motion on
    """

    trace = "One channel alone, by a constant, from the first motion on."
    offset = Param(0.3, "K", lo=-5.0, hi=5.0, null=0.0, source="a contact or wire that moved")
    channel = Param(
        1.0, "1", lo=1.0, hi=99.0, fixed=True, over="channel", source="by search; 1 is the first thermometer"
    )

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        for number, name in enumerate(rig.thermometers, start=1):
            yield Read(name, {}, 0.0, _of(number, p.channel) * p.offset * u.motion.moved)


class ChannelGain(Effect):
    """One thermometer shows more or less than the rise since the start.

    y = T_start + (1 + gain) (T - T_start)
    """

    trace = "One channel alone, in proportion to its own rise, at rest and while driving."
    scales = ("thermometers",)
    gain = Param(0.05, "1", lo=-0.5, hi=0.5, null=0.0, source="a wrong type constant, 1 - 5 %")
    channel = Param(
        1.0, "1", lo=1.0, hi=99.0, fixed=True, over="channel", source="by search; 1 is the first thermometer"
    )

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        deep = _deep(p.thermometers.bore, rig) if p.thermometers else 0.0
        for number, name in enumerate(rig.thermometers, start=1):
            gain, channel = _of(number, p.channel) * p.gain, rig.channels[name]
            spot = {SCREW: Spot(channel.at_mm, gain, deep)} if channel.at_mm is not None else {str(channel.node): gain}
            yield Read(name, spot, 0.0, -gain * u[START])


def _deep(bore: Any, rig: Rig) -> Any:
    """How much more than the mean of the section a thermometer follows what is beside it, mm2."""
    return bore * rig.screw.bore_mm2 if rig.screw else 0.0


def _of(number: int, channel: Any) -> float:
    """1 for the thermometer that is meant."""
    return float(number == round(channel.real))
