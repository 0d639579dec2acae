"""An effect: one physical sentence that can be absent, with its equation, its parameters and its terms."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, ClassVar

from estimator.errors import SetupError
from estimator.inputs.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import Term


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

    def __post_init__(self) -> None:
        if not self.lo <= self.value <= self.hi:
            raise SetupError(f"parameter default {self.value} {self.unit} is outside {self.lo} ... {self.hi}")


class Effect:
    """Base of all effects: subclasses declare Params as class attributes, an equation in the docstring, and `terms`.

    scales  other effects of the model whose parameters this one uses, as p.NAME; None where the model lacks one
    trace   what it leaves in the readings, in words
    """

    scales: ClassVar[tuple[str, ...]] = ()
    trace: ClassVar[str] = ""
    params: ClassVar[dict[str, Param]] = {}
    name: ClassVar[str] = "effect"

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        own = {key: value for key, value in vars(cls).items() if isinstance(value, Param)}
        cls.params = {**cls.params, **own}
        cls.name = re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()
        if not (cls.__doc__ or "").strip():
            raise SetupError(f"effect {cls.__name__}: the docstring with its equation is missing")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        """Yield the effect's terms for parameters `p`, inputs `u` and the rig; structure never depends on values."""
        raise SetupError(f"effect {self.name}: 'terms' is missing")

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


def needed(p: SimpleNamespace, name: str) -> SimpleNamespace:
    """Parameters of an effect that this one scales; a model without it is a SetupError."""
    found = getattr(p, name)
    if found is None:
        raise SetupError(f"needs the effect '{name}', which the model has not; add it first")
    assert isinstance(found, SimpleNamespace)
    return found
