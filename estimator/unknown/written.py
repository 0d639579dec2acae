"""Something unknown as a class of Python: its name, what its text needs, and the class that a text is."""

import re
from collections.abc import Collection, Mapping
from importlib import import_module
from itertools import count
from typing import Any

from estimator.effect import Effect
from estimator.model import Value
from estimator.unknown.effect_text import ALL, VOCABULARY, Wanted
from estimator.unknown.stand_ins import Unknown


def name_of(unknown: Unknown, taken: Collection[str]) -> str:
    """HeatNear300, LossInNut, ShiftOfT04; with a number where an effect or class has that name."""
    names = {each.replace("_", "").lower() for each in taken}
    name = _plain_name(unknown)
    numbered = (name if number == 1 else f"{name}No{number}" for number in count(1))
    return next(each for each in numbered if each.lower() not in names)


def _plain_name(unknown: Unknown) -> str:
    if unknown.channel is not None:
        return f"ShiftOf{_camel(unknown.channel or ALL)}"
    what = "Loss" if unknown.follower.loss else "Heat"
    if unknown.node is not None:
        return f"{what}In{_camel(unknown.node)}"
    if unknown.at_mm is not None:
        return f"{what}Near{'Minus' if unknown.at_mm < 0 else ''}{abs(round(unknown.at_mm, -1)):.0f}"
    return f"{what}UnderNut" if unknown.under_nut else f"{what}AllAlong"


def _camel(word: str) -> str:
    return "".join(part[:1].upper() + part[1:] for part in re.split(r"[^A-Za-z0-9]+", word))


def wanted_of(unknown: Unknown, cls: str, found: Mapping[str, Value], source: str = "by search") -> Wanted:
    """What a text of this name needs, with the values that were found."""
    reading = None if unknown.channel is None else unknown.channel or ALL
    return Wanted(cls, unknown.follower, unknown.at_mm, unknown.node, unknown.under_nut, reading, found, source)


def effect_of(text: str) -> type[Effect]:
    """The class that a text of `effect_text` is."""
    names: dict[str, Any] = {"__name__": __name__}
    for name, module in VOCABULARY.items():
        home = import_module(module)
        names[name] = getattr(home, name, home)
    before = set(names)
    exec(text, names)  # made of templates, numbers, and the rig's names as quoted texts
    (cls,) = (names[name] for name in names.keys() - before - {"__builtins__"})
    assert issubclass(cls, Effect)
    return cls
