"""Stand-ins for effects that no catalogue has: heat at a place, or an offset of a reading, that follows something.

These are never added to a model. Where one of them explains what no effect of the catalogue does, its place and what it
follows say what to look for on the machine.
"""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np

from estimator.effect import Effect, Param
from estimator.effects.local import spot
from estimator.inputs import Inputs
from estimator.record import Array
from estimator.rig import Rig
from estimator.terms import SCREW, Heat, Link, Read, Term

FADING_S = 300.0
HOUR = 3600.0
SHAPES = ("always", "drive", "rest", "early_drive", "early_stop", "speed", "speed2", "time")
TEMPERATURE = "temperature"


def followers(rig: Rig) -> tuple[str, ...]:
    """What something may follow on a rig: shapes of the motion, and every temperature that is an input."""
    own = [name for name, signal in rig.inputs.items() if signal.unit == "degC"]
    return (*SHAPES, *own) if "speed" in rig.inputs else ("always", "time", *rig.inputs)


def bodies(rig: Rig) -> tuple[str, ...]:
    """Bodies that thermometers read."""
    return tuple(sorted({channel.node for channel in rig.channels.values() if channel.node is not None}))


def following(name: str, u: Inputs, rig: Rig) -> Array:
    """What is followed, (ticks, 1), of the order of 1."""
    m = u.motion
    if name in SHAPES:
        speed = u.speed_law(rig.screw, 1.0) if rig.screw else u.omega
        shapes = {
            "always": np.ones_like(u.omega), "drive": m.turning, "rest": (1 - m.turning) * m.moved,
            "early_drive": m.turning * np.exp(-m.since_s / FADING_S),
            "early_stop": (1 - m.turning) * m.moved * np.exp(-m.since_s / FADING_S),
            "speed": speed, "speed2": speed**2 * u.unevenness, "time": m.time_s / HOUR,
        }  # fmt: skip
        return shapes[name]
    return u.rise(name)


class UnknownHeat(Effect):
    """Heat at one place that follows something.

    q = P f(t) around the place `at`, or g f (T - T_air) for what follows the temperature there
    """

    power = Param(1.0, "W", lo=-1000.0, hi=1000.0, null=0.0, source="by search")
    at = Param(400.0, "mm", lo=-500.0, hi=5000.0, over="place", source="by search")
    width = Param(30.0, "mm", lo=5.0, hi=300.0, fixed=True, source="a footprint")
    follows = Param(0.0, "1", lo=0.0, hi=99.0, fixed=True, over="follower", source="by search")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        names, which = followers(rig), round(p.follows.real)
        over = spot(rig, p.at, p.width)
        warm = float(which == len(names))
        if "ambient" in u:
            yield Link(SCREW, "ambient", -warm * p.power * over)
        yield Heat(SCREW, p.power * (1.0 - warm) * following(names[min(which, len(names) - 1)], u, rig), over=over)


class UnknownBodyHeat(Effect):
    """Heat into one of the bodies that thermometers read, which follows something.

    q = P f(t)
    """

    power = Param(1.0, "W", lo=-1000.0, hi=1000.0, null=0.0, source="by search")
    node = Param(0.0, "1", lo=0.0, hi=99.0, fixed=True, over="node", source="by search")
    follows = Param(0.0, "1", lo=0.0, hi=99.0, fixed=True, over="follower", source="by search")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        names, which = followers(rig), round(p.follows.real)
        for number, node in enumerate(bodies(rig)):
            here = p.power * float(number == round(p.node.real))
            warm = float(which == len(names))
            if "ambient" in u:
                yield Link(node, "ambient", -here * warm)
            yield Heat(node, here * (1.0 - warm) * following(names[min(which, len(names) - 1)], u, rig))


class UnknownReading(Effect):
    """A reading, or all thermometers alike, shifted by something that it follows.

    y = s + offset f(t)
    """

    offset = Param(0.1, "K or um", lo=-50.0, hi=50.0, null=0.0, source="by search")
    channel = Param(0.0, "1", lo=0.0, hi=99.0, fixed=True, over="reading", source="by search; 0 is all thermometers")
    follows = Param(0.0, "1", lo=0.0, hi=99.0, fixed=True, over="follower", source="by search")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        names, which = followers(rig), round(p.channel.real)
        shift = p.offset * following(names[min(round(p.follows.real), len(names) - 1)], u, rig)
        for number, name in enumerate(rig.names, start=1):
            meant = number == which or (which == 0 and name in rig.thermometers)
            yield Read(name, {}, 0.0, float(meant) * shift)
