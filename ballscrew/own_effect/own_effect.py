"""The text of a new effect: heat into the screw or a body, or a shift of readings, times what it follows."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from string import Template

from ballscrew.own_effect.followers import TEMPERATURE, Follower, follower_of
from estimator.rig import Rig

TEXT = Template('''class $cls(Effect):
    """$sentence

    $equation
    """

    trace = "$trace"
    $params

    def terms(self, p, u, rig):
        $body
''')
VOCABULARY = {  # every name that the text may use, and where it comes from
    "np": "numpy",
    "Effect": "estimator.effect",
    "Param": "estimator.effect",
    "spot": "estimator.effects.local",
    "ELONGATION": "estimator.terms",
    "SCREW": "estimator.terms",
    "START": "estimator.terms",
    "Heat": "estimator.terms",
    "Link": "estimator.terms",
    "Read": "estimator.terms",
    "Spot": "estimator.terms",
}
ALL = "all"  # in place of a channel: every thermometer


@dataclass(frozen=True)
class Spread:
    """Where a heat goes: in words, in the equation, and in Python as a heat q and as a link to the air."""

    what: str
    where: str
    equation: str
    heat: str
    link: str


ALONG = Spread(
    "the screw all along",
    "all along",
    "spread evenly along the screw",
    "yield Heat(SCREW, {q} / rig.the_screw().cells)",
    'yield Link(SCREW, "ambient", p.g / rig.the_screw().cells)',
)
AROUND = Spread(
    "the screw around {at:g} mm",
    "around {at:g} mm",
    "around the place `at`",
    "yield Heat(SCREW, {q}, over=spot(rig, p.at, p.width))",
    'yield Link(SCREW, "ambient", p.g * spot(rig, p.at, p.width))',
)
INTO = Spread("{node}", "in {node}", "into {node}", "yield Heat({name}, {q})", 'yield Link({name}, "ambient", p.g)')


@dataclass(frozen=True)
class Wanted:
    """A new effect: class name, place (mm; None: all along), what it follows, the reading that it shifts if any.

    node  the body that it heats, if not the screw
    """

    cls: str
    at_mm: float | None
    follows: str
    reading: str | None
    node: str | None = None

    @property
    def subject(self) -> str:
        """The class name in words: "Coolant jet"."""
        return re.sub(r"(?<!^)(?=[A-Z])", " ", self.cls).capitalize()


def effect_text(wanted: Wanted, rig: Rig) -> str:
    """The class as Python."""
    parts = _reading(wanted, rig) if wanted.reading else _heat(wanted, rig)
    return TEXT.substitute(parts, cls=wanted.cls)


def _heat(wanted: Wanted, rig: Rig) -> dict[str, str]:
    """Heat at a place, all along or into a body: q = P f; where it follows the temperature, a link to the air."""
    follower, first = follower_of(wanted.follows, rig), []
    spread = INTO if wanted.node is not None else ALONG if wanted.at_mm is None else AROUND
    place = {"at": wanted.at_mm, "node": wanted.node, "name": json.dumps(wanted.node)}
    where, what, equation = (text.format(**place) for text in (spread.where, spread.what, spread.equation))
    if wanted.follows == TEMPERATURE:
        params = [_param("g", 0.5, "W/K", 0.0, 20.0, "a guess", "null=0.0")]
        says, equation = f"takes heat from {what} to the air", f"q = -g (T - T_air), {equation}"
        yields = spread.link.format(**place)
    else:
        params, first = [_strength("power", 5.0, "W", follower)], _when(follower)
        says, equation = f"heats {what}", f"q = P{follower.symbol}, {equation}"
        yields = spread.heat.format(q=_times("p.power", follower), **place)
    if wanted.at_mm is not None:
        params += _place(wanted.at_mm, rig)
    return {
        "sentence": f"{wanted.subject} {says}, {follower.when}.",
        "equation": equation,
        "trace": f"Too warm or too cold {where}, {follower.when}.",
        "params": "\n    ".join(params),
        "body": "\n        ".join([*first, yields]),
    }


def _reading(wanted: Wanted, rig: Rig) -> dict[str, str]:
    """A shift of readings: y = T + shift f; where it follows the temperature, a gain of the reading's own rise."""
    assert wanted.reading is not None
    follower, length = follower_of(wanted.follows, rig), wanted.reading not in (ALL, *rig.thermometers)
    whose = "all thermometers" if wanted.reading == ALL else wanted.reading
    names = "rig.thermometers" if wanted.reading == ALL else f"({json.dumps(wanted.reading)},)"
    symbol = "X" if length else "T"
    if wanted.follows == TEMPERATURE:
        strength = _param("gain", 0.05, "1", -0.5, 0.5, "a guess", "null=0.0")
        sentence, equation = f"makes {whose} show more", f"y = {symbol} + gain ({symbol} - {symbol}_start)"
        first, yields = [], _gain(length)
    else:
        strength = _strength("shift", *((0.5, "um") if length else (0.3, "K")), follower)
        sentence, equation = f"shifts the reading of {whose}", f"y = {symbol} + shift{follower.symbol}"
        first, yields = _when(follower), [f"yield Read(name, {{}}, 0.0, {_times('p.shift', follower)})"]
    return {
        "sentence": f"{wanted.subject} {sentence}, {follower.when}.",
        "equation": equation,
        "trace": f"The reading of {whose} alone, {follower.when}.",
        "params": strength,
        "body": "\n        ".join([*first, f"for name in {names}:", *(f"    {line}" for line in yields)]),
    }


def _gain(length: bool) -> list[str]:
    """Statements that add a share of a reading's own change to it."""
    if length:
        return ["yield Read(name, {ELONGATION: p.gain}, 0.0)"]
    return [
        "node, at_mm = rig.channels[name].node, rig.channels[name].at_mm",
        "weights = {node: p.gain} if at_mm is None else {SCREW: Spot(at_mm, p.gain)}",
        "yield Read(name, weights, 0.0, -p.gain * u[START])",
    ]


def _place(at_mm: float, rig: Rig) -> list[str]:
    """The parameters of a place."""
    screw = rig.the_screw()
    return [
        _param("at", at_mm, "mm", screw.from_mm, screw.to_mm, "where it is mounted", "fixed=True"),
        _param("width", 30.0, "mm", 5.0, 300.0, "the length that it acts on, a guess", "fixed=True"),
    ]


def _strength(key: str, value: float, unit: str, follower: Follower) -> str:
    """The parameter that switches the effect off: this much at what the follower gets to."""
    per = f"({follower.unit})" if re.search(r"\W", follower.unit[1:]) else follower.unit
    value = float(f"{value / follower.typical:.1g}")
    bound = float(f"{20 * value:.2g}")
    return _param(key, value, f"{unit}/{per}" if per else unit, -bound, bound, "a guess", "null=0.0")


def _param(key: str, value: float, unit: str, lo: float, hi: float, source: str, more: str) -> str:
    return f'{key} = Param({value!r}, {json.dumps(unit)}, lo={lo!r}, hi={hi!r}, {more}, source="{source}")'


def _times(strength: str, follower: Follower) -> str:
    return f"{strength} * follows" if follower.factor else strength


def _when(follower: Follower) -> list[str]:
    """The statement that says what it follows, where that is anything."""
    return [f"follows = {follower.factor}"] if follower.factor else []
