"""The text of a new effect: heat into the screw or a body, or a shift of readings, times what it follows."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from importlib.resources import files
from string import Template

from estimator.inputs.follower import ALWAYS, TEMPERATURE, Follower
from estimator.rig import Rig

TEMPLATES = files("ballscrew.own_effect") / "templates"
TERMS = ("ELONGATION", "SCREW", "START", "Heat", "Link", "Read", "Spot")
VOCABULARY = {  # every name that the text may use, and where it comes from
    "np": "numpy",
    "Effect": "estimator.effect",
    "Param": "estimator.effect",
    "spot": "estimator.effects.local",
    **dict.fromkeys(TERMS, "estimator.terms"),
}
ALL = "all"  # in place of a channel: every thermometer
CELLS = " / rig.the_screw().cells"
SPOT = "spot(rig, p.at, p.width)"


@dataclass(frozen=True)
class Wanted:
    """A new effect: class name, what it follows, the body (else the screw) and place (None: all along) that it heats.

    reading  the channel that it shifts instead, or ALL
    """

    cls: str
    follows: Follower
    at_mm: float | None = None
    node: str | None = None
    reading: str | None = None


def effect_text(wanted: Wanted, rig: Rig) -> str:
    """The class as Python."""
    follows = wanted.follows
    kind, parts = _reading(wanted.reading, follows, rig) if wanted.reading is not None else _heat(wanted, rig)
    subject = re.sub(r"(?<!^)(?=[A-Z])", " ", wanted.cls).capitalize()
    words = {"when": follows.when, "symbol": follows.symbol, "formula": follows.formula}
    template = Template((TEMPLATES / f"{kind}.txt").read_text(encoding="utf-8"))
    text = template.substitute(parts, cls=wanted.cls, subject=subject, **words)
    if follows is ALWAYS:
        return text.replace(f"        follows = {ALWAYS.formula}\n", "").replace(" * follows", "")
    return text


def _heat(wanted: Wanted, rig: Rig) -> tuple[str, dict[str, str]]:
    """Heat at a place, all along or into a body; where it follows the temperature there, a link to the air."""
    parts = {"strength": _strength(5.0, "W", wanted.follows), "at": "", "node": "SCREW"}
    if wanted.node is not None:
        node = wanted.node
        parts |= {"what": node, "where": f"in {node}", "spread": f"into {node}", "share": "", "link": ""}
        parts["node"] = json.dumps(node)
    elif wanted.at_mm is None:
        spread = "spread evenly along the screw"
        parts |= {"what": "the screw all along", "where": "all along", "spread": spread, "share": CELLS, "link": CELLS}
    else:
        where, link = f"around {wanted.at_mm:g} mm", f" * {SPOT}"
        parts |= {"what": f"the screw {where}", "where": where, "spread": "around the place `at`", "link": link}
        parts |= {"share": f", over={SPOT}", "at": _place(wanted.at_mm, rig)}
    return "loss" if wanted.follows is TEMPERATURE else "heat", parts


def _reading(reading: str, follows: Follower, rig: Rig) -> tuple[str, dict[str, str]]:
    """A shift of readings; where it follows what is read, a gain."""
    length = reading not in (ALL, *rig.thermometers)
    parts = {
        "whose": "all thermometers" if reading == ALL else reading,
        "channels": "rig.thermometers" if reading == ALL else f"({json.dumps(reading)},)",
        "read": "X" if length else "T",
        "strength": _strength(*((0.5, "um") if length else (0.3, "K")), follows),
    }
    return ("gain_of_length" if length else "gain") if follows is TEMPERATURE else "shift", parts


def _place(at_mm: float, rig: Rig) -> str:
    """The parameters of a place."""
    screw, length = rig.the_screw(), "the length that it acts on, a guess"
    at = _param(at_mm, "mm", screw.from_mm, screw.to_mm, 'fixed=True, source="where it is mounted"')
    return f"\n    at = {at}\n    width = " + _param(30.0, "mm", 5.0, 300.0, f'fixed=True, source="{length}"')


def _strength(value: float, unit: str, follows: Follower) -> str:
    """The parameter that switches the effect off: this much at what the follower gets to."""
    per = f"({follows.unit})" if re.search(r"\W", follows.unit[1:]) else follows.unit
    value = float(f"{value / follows.typical:.1g}")
    most = float(f"{20 * value:.2g}")
    return _param(value, f"{unit}/{per}" if per else unit, -most, most, 'null=0.0, source="a guess"')


def _param(value: float, unit: str, lo: float, hi: float, more: str) -> str:
    return f"Param({value!r}, {json.dumps(unit)}, lo={lo!r}, hi={hi!r}, {more})"
