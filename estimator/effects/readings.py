"""What the sensors make of the temperatures: thermometers in the bore, and the displacement probes."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

from estimator.effect import Effect, Param
from estimator.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import ELONGATION, SCREW, Lag, Read, Spot, Term


class Thermometers(Effect):
    """Thermometers press on the bore, follow it with a lag, and shift with the temperature of their circuit board.

    y = s + board (T_board - T_board(0)) + zero,   tau ds/dt = T(x) - s

    zero_sd    thermometers differ by a constant each, ...
    zero_walk  ... which also stands in for what makes it change slowly: gain, and each one's own drift
    tau        holds the bore's delay behind the mean of the section too, about 2 s
    lag_noise  lags differ between thermometers by a quarter, and stay wrong for as long as a drive lasts: the filter
               weighs a reading as if its lag scattered by this much
    """

    sd = Param(0.022, "K", lo=0.005, hi=0.5, fixed=True, source="0.02 K scatter and 0.01 K steps")
    tau = Param(8.0, "s", lo=0.0, hi=30.0, null=0.0, source="3 - 15 s")
    lag_noise = Param(
        1.0, "1", lo=0.0, hi=20.0, fixed=True, source="by coverage on simulated runs; lags spread by a quarter"
    )
    zero_sd = Param(0.015, "K", lo=0.0, hi=1.0, fixed=True, source="0.05 K between 15 channels after warm-up")
    zero_walk = Param(0.0001, "K/sqrt(s)", lo=0.0, hi=0.1, fixed=True, source="0.006 K in an hour")
    board = Param(0.0, "K/K", lo=-0.02, hi=0.02, null=0.0, sd=0.003, source="0.03 K per 10 K")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        offset = p.board * u.rise("board")
        for name in rig.thermometers:
            channel = rig.channels[name]
            if channel.at_mm is not None:
                yield Read(name, {SCREW: Spot(channel.at_mm)}, p.sd, offset, p.zero_sd, p.zero_walk)
                yield Lag(name, p.tau, p.lag_noise)
            elif channel.node is not None:
                yield Read(name, {channel.node: 1.0}, p.sd, offset, p.zero_sd, p.zero_walk)


class Displacement(Effect):
    """The probes read the growth of the measured span, and their own and the bar's expansion.

    y = elongation + probe (T_probe - T_probe(0)) - bar (T_bar - T_bar(0)) + zero

    The zero is unknown, since the peak hold of the turning screw has no reading at rest to compare with.
    """

    sd = Param(0.15, "um", lo=0.01, hi=5.0, fixed=True, source="0.1 um scatter, hold error up to 0.19 um")
    probe = Param(0.3, "um/K", lo=0.0, hi=2.0, sd=0.3, source="at most 0.6 um in a run")
    bar = Param(0.5, "um/K", lo=0.0, hi=2.0, sd=0.3, source="super Invar, 0 - 1e-6 1/K over 0.94 m; at most 0.8 um")
    zero_sd = Param(100.0, "um", lo=0.0, hi=1000.0, fixed=True, source="disc wobble")
    zero_walk = Param(0.002, "um/sqrt(s)", lo=0.0, hi=0.1, fixed=True, source="tuned")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        offset = p.probe * u.rise("probe") - p.bar * u.rise("bar")
        yield Read("displacement", {ELONGATION: 1.0}, p.sd, offset, zero_sd=p.zero_sd, zero_walk=p.zero_walk)
