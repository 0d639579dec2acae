"""The text of a new effect: heat into the screw or a body, or a shift of readings, times what it follows."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from string import Template

from estimator.effect import Param
from estimator.inputs.follower import Follower
from estimator.model import Value
from estimator.rig import Rig
from estimator.unknown.law import Law, law_of

TEMPLATES = files("estimator.unknown") / "templates"
TERMS = ("ELONGATION", "SCREW", "START", "Heat", "Link", "Read", "Spot")
VOCABULARY = {  # every name that the text may use, and where it comes from
    "np": "numpy",
    "Effect": "estimator.effect",
    "Param": "estimator.effect",
    "spot": "estimator.effects.local",
    "per_cell": "estimator.effects.nut",
    **dict.fromkeys(TERMS, "estimator.terms"),
}
ALL = "all"  # in place of a channel: every thermometer
SAID = ("subject", "when", "symbol", "what", "where", "spread", "whose")  # in sentences, names of the rig in them
PLAIN = re.compile(r"""["\\\x00-\x1f]""")  # what would end a text of Python, or mean something in it
CELLS = " / rig.the_screw().cells"
SPOT = "spot(rig, p.at, p.width)"
CONDUCTANCE = Param(0.5, "W/K", lo=0.0, hi=20.0, null=0.0, source="a guess")
WIDTH_SD_MM = 40.0  # of a width of 30 mm: a nozzle to a tray of chips
ROOM = 4.0  # times what was found that a bound lies away at least
DIGITS = 6  # of a value that was found, as a model file has it


@dataclass(frozen=True)
class Wanted:
    """A new effect: class name, what it follows, the body (else the screw) and place (None: all along) that it heats.

    under_nut  it heats what the nut covers, wherever that is
    reading    the channel that it shifts instead, or ALL
    found      its parameters where they were found, by name, and then all of them are free; else they are guesses
    source     of what was found
    """

    cls: str
    follows: Follower
    at_mm: float | None = None
    node: str | None = None
    under_nut: bool = False
    reading: str | None = None
    found: Mapping[str, Value] | None = field(default=None, compare=False)
    source: str = ""

    @property
    def law(self) -> Law:
        """What it follows: with its numbers open where they are fitted."""
        follows = self.follows
        if self.found is not None:
            return law_of(follows)
        return Law(follows.when, follows.symbol, follows.formula)

    @property
    def subject(self) -> str:
        """What heats or shifts: its name, if it has one."""
        return "Something" if self.found is not None else re.sub(r"(?<!^)(?=[A-Z])", " ", self.cls).capitalize()

    def param(self, key: str, guess: Param) -> str:
        """A parameter as Python: its guess, or as it was found."""
        if self.found is None:
            value, lo, hi, fixed, source = guess.value, guess.lo, guess.hi, guess.fixed, guess.source
        else:
            value = float(f"{self.found[key].value:.{DIGITS}g}") if key in self.found else guess.value
            far = ROOM * abs(value) if guess.null is not None else 0.0
            lo, hi = min(guess.lo, -far if guess.lo < 0 else guess.lo), max(guess.hi, far)
            sd = self.found[key].sd if key in self.found else None
            fixed, source = False, f"{self.source}, +- {sd:.2g}" if sd else self.source
        more = {"null": guess.null, "sd": guess.sd if self.found is not None else None}
        said = [f"{name}={number!r}" for name, number in more.items() if number is not None]
        said += ["fixed=True"] * fixed + [f"source={json.dumps(source)}"]
        said += [f'over="{guess.over}"'] * bool(guess.over and self.found is not None)
        return f"Param({value!r}, {json.dumps(guess.unit)}, lo={lo!r}, hi={hi!r}, {', '.join(said)})"


def effect_text(wanted: Wanted, rig: Rig) -> str:
    """The class as Python."""
    law = wanted.law
    kind, parts = _reading(wanted, rig) if wanted.reading is not None else _heat(wanted, rig)
    words = {"when": law.when, "symbol": law.symbol, "subject": wanted.subject}
    parts |= {key: PLAIN.sub("'", text) for key, text in {**words, **parts}.items() if key in SAID}
    numbers = "".join(f"\n    {key} = {wanted.param(key, guess)}" for key, guess in law.numbers.items())
    template = Template((TEMPLATES / f"{kind}.txt").read_text(encoding="utf-8"))
    text = template.substitute(parts, cls=wanted.cls, formula=law.formula, numbers=numbers)
    if law.formula == "1.0":
        return text.replace("        follows = 1.0\n", "").replace(" * follows", "")
    return text


def _heat(wanted: Wanted, rig: Rig) -> tuple[str, dict[str, str]]:
    """Heat at a place, all along, under the nut or into a body; where it is a loss, a link to the air."""
    parts = {"at": "", "node": "SCREW", "heats": "cools" if _is_cold(wanted) else "heats"}
    if wanted.node is not None:
        node = wanted.node
        parts |= {"what": node, "where": f"in {node}", "spread": f"into {node}", "share": "", "link": ""}
        parts["node"] = json.dumps(node)
    elif wanted.at_mm is not None:
        place = f"{wanted.at_mm:g}" if wanted.found is None else f"{wanted.at_mm:.0f}"
        where, link = f"around {place} mm", f" * {SPOT}"
        parts |= {"what": f"the screw {where}", "where": where, "spread": "around the place `at`", "link": link}
        parts |= {"share": f", over={SPOT}", "at": _place(wanted, rig)}
    elif wanted.under_nut:
        share = " * per_cell(rig), over=u.coverage"
        parts |= {"what": "what the nut covers", "where": "under the nut", "spread": "under the nut"}
        parts |= {"share": share, "link": share}
    else:
        spread = "spread evenly along the screw"
        parts |= {"what": "the screw all along", "where": "all along", "spread": spread, "share": CELLS, "link": CELLS}
    if wanted.follows.loss:
        return "loss", parts | {"g": wanted.param("g", CONDUCTANCE)}
    return "heat", parts | {"strength": wanted.param("power", _strength(5.0, "W", wanted.follows))}


def _is_cold(wanted: Wanted) -> bool:
    power = (wanted.found or {}).get("power")
    return power is not None and power.value < 0


def _reading(wanted: Wanted, rig: Rig) -> tuple[str, dict[str, str]]:
    """A shift of readings; where it follows what is read, a gain."""
    reading, follows = wanted.reading, wanted.follows
    length = reading not in (ALL, *rig.thermometers)
    parts = {
        "whose": "all thermometers" if reading == ALL else str(reading),
        "channels": "rig.thermometers" if reading == ALL else f"({json.dumps(reading)},)",
        "read": "X" if length else "T",
        "strength": wanted.param("shift", _strength(*((0.5, "um") if length else (0.3, "K")), follows)),
    }
    return ("gain_of_length" if length else "gain") if follows.loss else "shift", parts


def _place(wanted: Wanted, rig: Rig) -> str:
    """The parameters of a place."""
    screw = rig.the_screw()
    at = Param(
        float(wanted.at_mm or 0.0), "mm", screw.from_mm, screw.to_mm, fixed=True, source="where it is mounted",
        over="place",
    )  # fmt: skip
    width = Param(30.0, "mm", 5.0, 300.0, fixed=True, sd=WIDTH_SD_MM, source="the length that it acts on, a guess")
    return f"\n    at = {wanted.param('at', at)}\n    width = {wanted.param('width', width)}"


def _strength(value: float, unit: str, follows: Follower) -> Param:
    """The parameter that switches the effect off: this much at what the follower gets to."""
    per = f"({follows.unit})" if re.search(r"\W", follows.unit[1:]) else follows.unit.removesuffix("1")
    value = float(f"{value / follows.typical:.1g}")
    most = float(f"{20 * value:.2g}")
    return Param(value, f"{unit}/{per}" if per else unit, -most, most, null=0.0, source="a guess")
