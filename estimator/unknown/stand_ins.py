"""Stand-ins for effects that no catalogue has: heat at a place, or an offset of a reading, that follows something.

These are never added to a model. Where one of them explains what no effect of the catalogue does, its place and what it
follows say what to look for on the machine.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from estimator.effect import Effect, Param
from estimator.effects.local import spot
from estimator.effects.nut import per_cell
from estimator.hypotheses.candidates import Candidate
from estimator.inputs.follower import Follower, all_followers
from estimator.inputs.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import SCREW, Heat, Link, Read, Term


class UnknownHeat(Effect):
    """Heat at one place that follows something.

    q = P f(t) around the place `at`, or P f (T_air - T) for what follows the temperature there
    """

    power = Param(1.0, "W", lo=-1000.0, hi=1000.0, null=0.0, source="by search")
    at = Param(400.0, "mm", lo=-500.0, hi=5000.0, over="place", source="by search")
    width = Param(30.0, "mm", lo=5.0, hi=300.0, fixed=True, source="a footprint")
    follows = Param(0.0, "1", lo=0.0, hi=99.0, fixed=True, over="follower", source="by search")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        yield from _heat(SCREW, p.power, _followed(p, rig), u, rig, spot(rig, p.at, p.width))


class UnknownSpreadHeat(Effect):
    """Heat all along the screw, or into what is under the nut wherever it is, that follows something.

    q = P f(t), or P f (T_air - T) for what follows the temperature there
    """

    power = Param(1.0, "W", lo=-1000.0, hi=1000.0, null=0.0, source="by search")
    under = Param(0.0, "1", lo=0.0, hi=1.0, fixed=True, over="spread", source="by search; 1 is under the nut")
    follows = Param(0.0, "1", lo=0.0, hi=99.0, fixed=True, over="follower", source="by search")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        follower, under = _followed(p, rig), float(p.under.real > 0.5)
        yield from _heat(SCREW, p.power * (1.0 - under) / rig.the_screw().cells, follower, u, rig)
        if rig.nut is not None:
            yield from _heat(SCREW, p.power * under * per_cell(rig), follower, u, rig, u.coverage)


class UnknownBodyHeat(Effect):
    """Heat into one of the bodies that thermometers read, which follows something.

    q = P f(t), or P f (T_air - T) for what follows the temperature there
    """

    power = Param(1.0, "W", lo=-1000.0, hi=1000.0, null=0.0, source="by search")
    node = Param(0.0, "1", lo=0.0, hi=99.0, fixed=True, over="node", source="by search")
    follows = Param(0.0, "1", lo=0.0, hi=99.0, fixed=True, over="follower", source="by search")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        for number, node in enumerate(rig.bodies):
            here = p.power * float(number == round(p.node.real))
            yield from _heat(node, here, _followed(p, rig), u, rig)


class UnknownReading(Effect):
    """A reading, or all thermometers alike, shifted by something that it follows.

    y = s + offset f(t)
    """

    offset = Param(0.1, "K or um", lo=-50.0, hi=50.0, null=0.0, source="by search")
    channel = Param(0.0, "1", lo=0.0, hi=99.0, fixed=True, over="reading", source="by search; 0 is all thermometers")
    follows = Param(0.0, "1", lo=0.0, hi=99.0, fixed=True, over="follower", source="by search")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        follower, which = _followed(p, rig), round(p.channel.real)
        shift = p.offset * float(not follower.loss) * follower.values(u, rig)
        for number, name in enumerate(rig.names, start=1):
            meant = number == which or (which == 0 and name in rig.thermometers)
            yield Read(name, {}, 0.0, float(meant) * shift)


def _followed(p: SimpleNamespace, rig: Rig) -> Follower:
    return all_followers(rig)[round(p.follows.real)]


def _heat(node: str, power: Any, follower: Follower, u: Inputs, rig: Rig, over: Any = 1.0) -> Iterator[Term]:
    """Heat that follows something, and what it takes to the air."""
    values, loss = follower.values(u, rig), float(follower.loss)
    if "ambient" in u:
        lost = values if follower.loss else 1.0  # conductances follow nothing but the speed
        yield Link(node, "ambient", loss * power * lost, over=over)
    yield Heat(node, (1.0 - loss) * power * values, over=over)


STAND_INS = (UnknownHeat, UnknownSpreadHeat, UnknownBodyHeat, UnknownReading)


@dataclass(frozen=True)
class Unknown:
    """What a stand-in stands for.

    at_mm    heat at a place;   node: or in a body;   under_nut: or into what the nut covers; else all along the screw
    channel  no heat, but a shift of this reading, "" for all thermometers
    """

    follower: Follower
    at_mm: float | None = None
    node: str | None = None
    under_nut: bool = False
    channel: str | None = None

    @property
    def place(self) -> str:
        """At 350 mm, in nut, T04."""
        if self.channel is not None:
            return self.channel or "all thermometers"
        if self.node is not None:
            return f"in {self.node}"
        along = "under the nut" if self.under_nut else "all along the screw"
        return along if self.at_mm is None else f"at {self.at_mm:.0f} mm"

    @property
    def what(self) -> str:
        """Heat at 350 mm, an offset of T04."""
        return f"{'heat' if self.channel is None else 'an offset of'} {self.place}"


def unknown_of(candidate: Candidate, rig: Rig) -> Unknown:
    """A stand-in where a search has put it."""
    at = {path.partition(".")[2]: value for path, value in candidate.at.items()}
    follower = all_followers(rig)[round(at["follows"])]
    if "channel" in at:
        return Unknown(follower, channel=("", *rig.names)[round(at["channel"])])
    if "node" in at:
        return Unknown(follower, node=rig.bodies[round(at["node"])])
    return Unknown(follower, at_mm=at.get("at"), under_nut=at.get("under", 0.0) > 0.5)
