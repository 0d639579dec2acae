"""An effect: one physical sentence that can be absent, with its equation, its parameters and its terms."""

import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass
from numbers import Real
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np

from estimator.errors import SetupError
from estimator.inputs.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import Term

OVER = ("", "place", "channel", "follower", "node", "spread", "reading")  # from the fourth on a search tries them
MOST = 1e12  # no parameter is larger; bounds may be infinite


@dataclass(frozen=True)
class Param:
    """A parameter of an effect: default, unit, bounds, null and where the numbers come from.

    null   the value at which the effect is invisible (only parameters that switch the effect off have one)
    sd     prior standard deviation, where a table value with a tolerance is known
    fixed  not fitted unless a model file says so
    over   "place" or "channel": where the effect sits. Nothing tells it while the effect is at its null, so that a
           search tries places along the screw, or the thermometers by number, 1 first
    """

    value: float
    unit: str
    lo: float = -float("inf")
    hi: float = float("inf")
    null: float | None = None
    sd: float | None = None
    fixed: bool = False
    source: str = ""
    over: str = ""

    def wrong(self) -> Iterator[str]:
        """What cannot be of it, a sentence each."""
        numbers: dict[str, Any] = {key: getattr(self, key) for key in ("value", "lo", "hi", "null", "sd")}
        numbers = {key: number for key, number in numbers.items() if key not in ("null", "sd") or number is not None}
        for key, number in numbers.items():
            if isinstance(number, bool) or not isinstance(number, Real):
                yield f"{key} is {number!r:.60}, must be a number"
                return
        texts: list[Any] = [self.unit, self.source]
        if not all(isinstance(text, str) for text in texts):
            yield "unit and source must be texts"
        if self.over not in OVER or str(self.fixed) not in ("True", "False"):
            yield 'over must be "", "place" or "channel", and fixed True or False'
        yield from self._out_of_bounds(numbers)

    def _out_of_bounds(self, numbers: dict[str, Any]) -> Iterator[str]:
        if not self.lo < self.hi:
            yield f"lo = {self.lo:g} is not below hi = {self.hi:g}"
        for key, number in numbers.items():
            if not abs(number) <= MOST and (key not in ("lo", "hi") or np.isfinite(number)):
                yield f"{key} is {number:g}, must be a number up to {MOST:g}"
            elif key in ("value", "null") and not self.lo <= number <= self.hi:
                yield f"{key} = {number:g} {self.unit} is outside {self.lo:g} ... {self.hi:g}"
        if self.sd is not None and not self.sd > 0:
            yield f"sd is {self.sd:g}, must be above 0"


class Effect:
    """Base of all effects: subclasses declare Params as class attributes, an equation in the docstring, and `terms`.

    scales  other effects of the model whose parameters this one uses, as p.NAME; None where the model lacks one
    apart   its parameters are asked for one at a time, for each makes a cover of its own; and are known as well where
            the machine may be another: else they would explain a table that stands elsewhere
    trace   what it leaves in the readings, in words
    """

    scales: ClassVar[tuple[str, ...]] = ()
    apart: ClassVar[bool] = False
    trace: ClassVar[str] = ""
    params: ClassVar[dict[str, Param]] = {}
    name: ClassVar[str] = "effect"

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        own = {key: value for key, value in vars(cls).items() if isinstance(value, Param)}
        cls.params = {**cls.params, **own}
        cls.name = re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()
        for wrong in _wrong(cls, own):
            raise SetupError(f"effect {cls.__name__}: {wrong}")

    def __repr__(self) -> str:
        return f"{type(self).__name__}()"

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        """Yield the effect's terms for parameters `p`, inputs `u` and the rig; structure never depends on values."""
        raise SetupError(f"effect {self.name}: 'terms' is missing")

    def inputs(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Inputs:
        """The inputs as all effects are to see them: as they stand, unless this effect says that one was told wrong."""
        return u

    @classmethod
    def sentence(cls) -> str:
        """First line of the docstring: what the effect says."""
        return inspect.cleandoc(cls.__doc__ or "").splitlines()[0]

    @classmethod
    def equation(cls) -> str:
        """The rest of the docstring: the equation, with its symbols."""
        return inspect.cleandoc(cls.__doc__ or "").partition("\n")[2].strip()

    def namespace(self, values: dict[str, Any]) -> SimpleNamespace:
        """Parameter values as attributes, defaults filled in."""
        return SimpleNamespace(**{key: values.get(key, param.value) for key, param in self.params.items()})


def _wrong(cls: Any, own: dict[str, Param]) -> Iterator[str]:
    """What makes a class no effect, a sentence each."""
    if not (cls.__doc__ or "").strip():
        yield "the docstring with its equation is missing"
    if not callable(cls.terms) or cls.__init__ is not Effect.__init__:
        yield "it needs a method terms(self, p, u, rig), and has no __init__: values come with p"
    if not isinstance(cls.scales, tuple) or not all(isinstance(name, str) for name in cls.scales):
        yield f"scales is {cls.scales!r:.60}, must be the names of other effects: ('nut_friction',)"
    if not isinstance(cls.trace, str):
        yield f"trace is {cls.trace!r:.60}, must be a text"
    for key, param in own.items():
        yield from (f"{key}: {wrong}" for wrong in param.wrong())
    if "use" in own:
        yield "use: a model file means the effect's file by it; call the parameter otherwise"


def needed(p: SimpleNamespace, name: str) -> SimpleNamespace:
    """Parameters of an effect that this one scales; a model without it is a SetupError."""
    found = getattr(p, name)
    if found is None:
        raise SetupError(f"needs the effect '{name}', which the model has not; add it first")
    assert isinstance(found, SimpleNamespace)
    return found
