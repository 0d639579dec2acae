"""Where things are on a rig of which only a recording is known: places and sizes to begin with, to be edited."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ballscrew.new_rig.drive import lead_of, round_up
from ballscrew.new_rig.seen import Guess
from ballscrew.new_rig.temperatures import THERMOMETER
from ballscrew.new_rig.words import LEAD_MM
from estimator.errors import SetupError
from estimator.screw import Nut, Screw, Support

FEWEST = 3  # thermometers that show a profile; fewer are each on a body of its own
_SCREW_MM, _ROD_MM = 1000.0, 400.0  # from the first thermometer to the last
_LONGEST_MM = 4000.0  # between two bearings alone states stand 28 mm apart, 200 at most
_JOURNAL_MM, _END_MM = 50.0, 20.0  # beyond them, of a screw and of a rod
_SCREW_OUTER_MM, _ROD_OUTER_MM = 40.0, 20.0
_LEADS_MM = 0.5, 200.0
_BEARING_MM, _NUT_MM = 30.0, 150.0


@dataclass(frozen=True)
class Geometry:
    """The parts of a rig, and where its thermometers are: at_mm on the screw, or nodes.

    told  whether the places were given; else they are even
    """

    at_mm: Mapping[str, float] = field(default_factory=dict)
    nodes: Mapping[str, str] = field(default_factory=dict)
    screw: Screw | None = None
    nut: Nut | None = None
    supports: Mapping[str, Support] = field(default_factory=dict)
    told: bool = False
    lead_found: bool = False

    def guessed(self) -> Iterator[tuple[str, str, tuple[str, ...]]]:
        """What must come from a person: what it is, its value, and the keys of rig.toml that have it."""
        if self.nodes:
            yield "what each thermometer is on", "a body of its own", tuple(self.nodes)
        screw = self.screw
        if screw is None:
            return
        if not self.told:
            first, last = min(self.at_mm.values()), max(self.at_mm.values())
            yield "where each thermometer is", f"evenly, {first:g} ... {last:g} mm, in their order", tuple(self.at_mm)
        ends = f"{screw.from_mm:g} ... {screw.to_mm:g} mm, {screw.outer_mm:g} mm thick, solid"
        yield "ends and diameters", ends, ("from_mm", "to_mm", "outer_mm", "bore_mm", "lead_mm")
        yield "material", "steel", ("density", "heat_capacity", "conductivity", "expansion")
        span = "{:g} ... {:g} mm".format(*screw.span_mm)
        yield "the length whose growth counts", span, ("span_from_mm", "span_to_mm")
        if self.nut is not None:
            now = f"{self.nut.length_mm:g} mm long, its centre at {self.nut.centre_mm:g} mm + position"
            yield "the nut: length, place, direction", now, ("length_mm", "centre_mm", "direction")
        if self.supports:
            now = ", ".join(f"{name} at {one.at_mm:g} mm" for name, one in self.supports.items())
            yield "the bearings; anchor is the fixed one", now, tuple(self.supports)


def geometry(guesses: Sequence[Guess], places: Sequence[float]) -> Geometry:
    """A screw where something moves or grows, else a rod; two thermometers alone are on two bodies."""
    names = [guess.name for guess in guesses if guess.role == THERMOMETER]
    by_role = {guess.role: guess for guess in guesses}
    if places and len(places) != len(names):
        raise SetupError(f"--places: {len(places)} of them, but {len(names)} thermometers: {', '.join(names)}")
    if not {"speed", "position", "displacement"} & {*by_role} and len(names) < FEWEST and not places:
        return Geometry(nodes={name: f"body_{k}" for k, name in enumerate(names, start=1)})
    drive = "speed" in by_role or "position" in by_role
    at_mm = list(places) or _even(len(names), by_role.get("position"), drive)
    first, last = min(at_mm), max(at_mm)
    last = last if last > first else first + _ROD_MM
    moving = {"speed", "position"} <= {*by_role}
    lead = lead_of(by_role["speed"].seen[0], by_role["position"].seen[0]) if moving else None
    lead = lead if lead and _LEADS_MM[0] < lead < _LEADS_MM[1] else None
    beyond = _JOURNAL_MM if drive else _END_MM
    screw = Screw(
        first - beyond, last + beyond, _SCREW_OUTER_MM if drive else _ROD_OUTER_MM, lead_mm=lead or LEAD_MM,
        span_from_mm=first, span_to_mm=last,
    )  # fmt: skip
    supports = {"free": Support(first, _BEARING_MM), "anchor": Support(last, _BEARING_MM)} if drive else {}
    nut = _nut(by_role["position"], screw) if moving else None
    where = dict(zip(names, at_mm, strict=True))
    return Geometry(where, {}, screw, nut, supports, bool(places), lead is not None)


def _even(count: int, position: Guess | None, drive: bool) -> list[float]:
    """Places one as far from the next as the other, over a screw that is longer than its stroke."""
    length = _SCREW_MM if drive else _ROD_MM
    if position is not None:
        length = min(max(length, round_up(float(np.ptp(position.value)) + 2 * _NUT_MM)), _LONGEST_MM)
    return [round(place) * 1.0 for place in np.linspace(0.0, length, count)] if count > 1 else [length / 2]


def _nut(position: Guess, screw: Screw) -> Nut:
    """A nut that is in the middle of the screw in the middle of its stroke."""
    low, high = np.percentile(position.value, (0, 100))
    return Nut(_NUT_MM, round((screw.from_mm + screw.to_mm) / 2 - (low + high) / 2) * 1.0, 1.0)
