"""What no effect explains, in the words of the rig: where it sits, what it follows, and how to begin with it."""

from __future__ import annotations

from dataclasses import dataclass

from estimator.inputs.follower import TEMPERATURE, bodies, followers
from estimator.missing_effect.screen import Screened
from estimator.rig import Rig


@dataclass(frozen=True)
class Stranger:
    """Where something sits that no effect explains, and what it follows; of heat the place in mm or the body."""

    heat: bool
    follows: str
    what: str
    at_mm: float | None = None
    node: str | None = None


def stranger_of(found: Screened, rig: Rig) -> Stranger:
    """A stand-in for something unknown, in the words of the rig."""
    at = {path.partition(".")[2]: value for path, value in found.candidate.at.items()}
    names = (*followers(rig), TEMPERATURE)
    follows = names[round(at["follows"])]
    if found.candidate.kind == "heat":
        if "at" in at:
            return Stranger(True, follows, f"at {at['at']:.0f} mm", at_mm=at["at"])
        node = bodies(rig)[round(at["node"])]
        return Stranger(True, follows, f"in {node}", node=node)
    number = round(at["channel"])
    return Stranger(False, follows, rig.names[number - 1] if number else "all thermometers")


def new_effect_line(who: Stranger) -> str:
    """The command that writes an effect file to start from."""
    if not who.heat:
        channel = "all" if who.what == "all thermometers" else who.what
        return f"ballscrew new-effect my_reading --reading {channel} --follows {who.follows}"
    at = f"{who.at_mm:.0f}mm" if who.at_mm is not None else who.node
    return f"ballscrew new-effect my_heat --at {at} --follows {who.follows}"


def followed(name: str) -> str:
    """What is followed, in words."""
    words = {"always": "nothing: it is always there", "drive": "the drive", "rest": "the rests", "time": "the clock",
             "early_drive": "the first minutes of drives", "early_stop": "the first minutes of stops",
             "speed2": "the speed squared", TEMPERATURE: "the temperature there"}  # fmt: skip
    return words.get(name, f"the {name}")
