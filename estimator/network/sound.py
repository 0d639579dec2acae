"""Whether what an effect yields can be: names, shapes and numbers of its terms, and their ticks.

Asked of every effect that is a user's own, each time it yields.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from estimator.errors import SetupError
from estimator.inputs.inputs import Inputs
from estimator.model import Model
from estimator.rig import Rig
from estimator.terms import (
    ELONGATION,
    OF_TICKS,
    SCREW,
    START,
    Chain,
    Expand,
    Heat,
    Hold,
    Lag,
    Link,
    Read,
    Shift,
    Spot,
    Store,
    Term,
)

OURS = __name__.partition(".")[0]  # the package that effects of the catalogue and stand-ins come from
ONE, TICKS, CELLS, BOTH = "one", "ticks", "cells", "ticks and cells"  # what a number is the same for, or as many as
EACH = "each cell"  # as many as cells, never one for all


@dataclass(frozen=True)
class Number:
    """What a number of a term may be: from lo to hi, of a shape.

    forced  it may follow any input, and so is asked for with the inputs of a run only
    """

    shape: str
    lo: float
    hi: float
    unit: str = ""
    forced: bool = False


NUMBERS: Mapping[type, Mapping[str, Number]] = {  # wide enough for any machine
    Store: {"capacity": Number(CELLS, 1e-6, 1e12, "J/K"), "noise": Number(BOTH, 1e-12, 1e9, "W/sqrt(Hz)")},
    Chain: {"g": Number(CELLS, 0.0, 1e9, "W/K")},
    Link: {"g": Number(BOTH, 0.0, 1e9, "W/K"), "over": Number(BOTH, 0.0, 1e6)},
    Heat: {
        "q": Number(BOTH, -1e9, 1e9, "W", forced=True),
        "over": Number(BOTH, -1e6, 1e6),
        "noise": Number(BOTH, 0.0, 1e9, "W/sqrt(Hz)"),
    },
    Read: {
        "sd": Number(ONE, 0.0, 1e6),
        "offset": Number(TICKS, -1e6, 1e6, forced=True),
        "zero_sd": Number(ONE, 0.0, 1e6),
        "zero_walk": Number(ONE, 0.0, 1e6),
        "gain_sd": Number(ONE, 0.0, 1.0),
    },
    Lag: {"tau": Number(ONE, 0.0, 1e6, "s"), "noise": Number(ONE, 0.0, 1e6), "own_sd": Number(ONE, 0.0, 10.0)},
    Expand: {"error": Number(ONE, -0.9, 9.0)},
    Hold: {
        "anchor_mm": Number(ONE, -1e6, 1e6, "mm"),
        "by_mm": Number(ONE, -1e6, 1e6, "mm"),
        "squeeze": Number(ONE, 0.0, 1.0),
        "give": Number(ONE, 0.0, 1.0),
    },
    Shift: {"by": Number(TICKS, -1e4, 1e4, forced=True), "over": Number(CELLS, -1e6, 1e6)},
}
WEIGHTS = (-1e6, 1e6)
NAMES = ("node", "a", "b", "channel", "input")
ALIKE = "structure never depends on values: yield the same terms, with zeros in them"
STEP = 1e-12  # imaginary parts below are the complex step of a derivative


@dataclass(frozen=True)
class Asked:
    """The inputs that terms are asked for with; `forced`: they are those of a run."""

    u: Inputs
    rig: Rig
    forced: bool = True

    def when(self, k: int = 0) -> str:
        """The time of tick k since the first sample."""
        time_s = float(self.u.motion.time_s[k, 0])
        return f" at {time_s:g} s (tick {time_s / self.rig.tick_s:.0f})" if self.forced else ""


class Sound:
    """The terms of a model on a rig; what is wrong with those of a user's own effects is an EffectError.

    Whatever the inputs, the terms are those of the first time with other numbers.
    """

    def __init__(self, model: Model, rig: Rig) -> None:
        self.model, self.rig = model, rig
        self._usual: dict[str, object] = {}
        self._in_ticks: dict[str, bool] = {}

    def terms(self, u: Inputs, forced: bool = True) -> list[Term]:
        """All terms at inputs `u`; where these are `forced`, those of a run, all that say something of its ticks.

        What our own effects say of regimes alone is sound and not asked for at each tick.
        """
        asked = (name for name in self.model.effects if not forced or self._in_ticks.get(name, True))
        return [term for name in asked for term in self.of(name, u, forced)]

    def of(self, name: str, u: Inputs, forced: bool = True) -> list[Term]:
        """Those of one effect."""
        terms, asked = self.model.terms_of(name, u, self.rig), Asked(u, self.rig, forced)
        if type(self.model.effects[name]).__module__.partition(".")[0] == OURS:
            self._in_ticks.setdefault(name, any(isinstance(term, OF_TICKS) for term in terms))
            return terms
        for wrong in unsound(terms, asked):
            raise self.model.error(name, wrong)
        if skeleton(terms) != self._usual.setdefault(name, skeleton(terms)):
            raise self.model.error(name, f"yields other terms{asked.when()} than at first; {ALIKE}")
        return terms

    def blame(self, u: Inputs) -> SetupError:
        """Why something that is made of the terms is no number."""
        for name in self.model.effects:
            for wrong in unsound(self.model.terms_of(name, u, self.rig), Asked(u, self.rig)):
                return self.model.error(name, wrong)
        return SetupError(f"{self.model.name}: its heat or readings are too large for a number")


def skeleton(terms: Sequence[Term]) -> list[object]:
    """Terms without their numbers."""
    return [
        (type(t), [v for v in vars(t).values() if isinstance(v, (str, bool))], tuple(getattr(t, "weights", ())))
        for t in terms
    ]


def unsound(terms: Sequence[Term], asked: Asked) -> Iterator[str]:
    """What is wrong with terms, a sentence for each of them at most."""
    for number, term in enumerate(terms, start=1):
        wrong = next(_words(term, asked.rig), "") or next(_numbers(term, asked), "")
        if wrong:
            yield f"{label(number, term)}: {wrong}"
    if not terms:
        yield "yields no term; yield one with 0 rather than none"


def label(number: int, term: Term) -> str:
    """A term as a person finds it in the effect's file."""
    names = [f"{getattr(term, key)!s:.60}" for key in NAMES if hasattr(term, key)]
    return f"term {number}, {type(term).__name__}{' of ' if names else ''}{' - '.join(names)}"


def _words(term: Term, rig: Rig) -> Iterator[str]:
    for key in NAMES:
        if not isinstance(getattr(term, key, ""), str):
            yield f"{key} is {_brief(getattr(term, key))}, must be a name"
    if not isinstance(getattr(term, "start", None), (str, type(None))):
        yield f"start is {_brief(getattr(term, 'start', None))}, must be the name of an input"
    if not isinstance(getattr(term, "spare", False), bool):
        yield f"spare is {_brief(getattr(term, 'spare', None))}, must be True or False"
    if isinstance(term, Store) and term.node in (START, ELONGATION):
        yield f"'{term.node}' stores no heat; choose another name"
    if isinstance(term, Chain) and term.node != SCREW:
        yield "a Chain is along the screw; between bodies there are Links"
    if isinstance(term, Hold) and term.anchor_mm == term.by_mm:
        yield "both its bearings are at one place"
    if isinstance(term, Link) and term.a == term.b:
        yield "both its ends are the same"
    if isinstance(term, Read) and not (isinstance(term.weights, Mapping) and all(map(_is_text, term.weights))):
        yield f"weights are {_brief(term.weights)}, must be {{node: weight}}"
    elif isinstance(term, Read) and ELONGATION in term.weights and term.channel in rig.thermometers:
        yield "a thermometer reads no elongation"


def _is_text(word: object) -> bool:
    return isinstance(word, str)


def _numbers(term: Term, asked: Asked) -> Iterator[str]:
    cells = asked.rig.screw.cells if asked.rig.screw else 1
    on_screw = isinstance(term, Shift) or SCREW in (getattr(term, key, "") for key in NAMES)
    size = (cells if on_screw else 1) - isinstance(term, Chain)
    for key, number in NUMBERS[type(term)].items():
        yield from _wrong(key, getattr(term, key), number, size, asked)
    for node, weight in getattr(term, "weights", {}).items():
        if isinstance(weight, Spot):
            yield from _off(weight, asked.rig)
            yield from _wrong("the weight of a Spot", weight.weight, Number(ONE, *WEIGHTS), 1, asked)
            yield from _wrong("how deep a Spot is", weight.deep, Number(ONE, 0.0, 1e5, "mm2"), 1, asked)
        else:
            shape = EACH if node == SCREW else ONE
            yield from _wrong(f"the weight of {node}", weight, Number(shape, *WEIGHTS), cells, asked)


def _off(spot: Spot, rig: Rig) -> Iterator[str]:
    """A spot that is not on the screw."""
    ends = (rig.screw.from_mm, rig.screw.to_mm) if rig.screw else (0.0, 0.0)
    if not isinstance(spot.at_mm, (int, float)) or not ends[0] <= spot.at_mm <= ends[1]:
        yield f"a Spot is at {_brief(spot.at_mm)} mm, must be on the screw, {ends[0]:g} ... {ends[1]:g} mm"


def _wrong(key: str, value: Any, number: Number, size: int, asked: Asked) -> Iterator[str]:
    """A number that is none, of a wrong shape or, where it is asked for, out of bounds; what is NaN is that too."""
    array = _array(value)
    if array.dtype.kind not in "biufc":
        yield f"{key} is {_brief(value)}, must be a number"
        return
    ticks = len(asked.u)
    shape = {ONE: (), TICKS: (ticks, 1), CELLS: (size,), BOTH: (ticks, size), EACH: (size,)}[number.shape]
    if number.shape == EACH and array.shape != shape:
        yield f"{key} has the shape {array.shape}, must be a Spot or have {shape}"
        return
    if not _fits(array.shape, shape):
        yield f"{key} has the shape {array.shape}, must be a number{f' or fit {shape}' if shape else ''}"
        return
    if (number.forced and not asked.forced) or _inside(array, number):
        return
    good = (array.real >= number.lo) & (array.real <= number.hi) & (abs(array.imag) < STEP)
    rows = np.flatnonzero(~good.all(axis=-1)) if array.ndim == 2 else np.zeros(1, int)
    more = f" and {len(rows) - 1} ticks more" if len(rows) > 1 else ""
    bounds = f"{number.lo:g} ... {number.hi:g} {number.unit}".rstrip()
    yield f"{key} is {array[~good][0]:g}{asked.when(rows[0])}{more}, must be {bounds}"


def _inside(array: Any, number: Number) -> bool:
    """Whether all is within bounds: asked of each number at each tick of a run, and so without arrays of its own."""
    if not array.size:
        return True
    imaginary = abs(array.imag).max() if array.dtype.kind == "c" else 0.0
    return bool(array.real.min() >= number.lo and array.real.max() <= number.hi and imaginary < STEP)


def _array(value: Any) -> Any:
    try:
        return np.asarray(value)
    except ValueError:  # lists of unlike lengths
        return np.array(None)


def _fits(shape: tuple[int, ...], wanted: tuple[int, ...]) -> bool:
    """Whether an array of this shape broadcasts to the wanted one."""
    pairs = zip(shape[::-1], wanted[::-1], strict=False)
    return len(shape) <= len(wanted) and all(n in (1, most) for n, most in pairs)


def _brief(value: object) -> str:
    return f"{value!r:.60}"
