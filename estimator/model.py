"""A model: a list of effects with the values of their parameters; composed with + and -, kept as TOML."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from textwrap import indent
from traceback import extract_tb
from types import MappingProxyType, SimpleNamespace
from typing import Any

import numpy as np
import scipy

from estimator.effect import Effect, Param
from estimator.errors import EffectError, SetupError, nearest
from estimator.inputs.inputs import Inputs
from estimator.record import Array
from estimator.rig import Rig
from estimator.terms import Term

DIGITS = 4  # of a correlation
SMALLEST = 1e-300
UNKNOWN: Mapping[str, Any] = MappingProxyType({"paths": (), "correlation": np.eye(0)})
MOST_TERMS = 2000  # of one effect
EXPANSION = "expansion_error.error"


@dataclass(frozen=True)
class Prior:
    """What is known of a parameter before anything was measured: a value and its standard deviation."""

    value: float
    sd: float


@dataclass(frozen=True)
class Value:
    """A parameter's value in one model, with its standard deviation where it was fitted.

    prior, lo, hi  instead of what the effect says of it, where the model knows better
    """

    value: Any
    sd: float | None = None
    fixed: bool = False
    prior: Prior | None = None
    lo: float | None = None
    hi: float | None = None

    def __str__(self) -> str:
        known = f" +- {self.sd:.2g}" if self.sd is not None else ""
        return f"{self.value:.5g}{known}"

    def over(self, param: Param) -> Param:
        """The declaration with what the model knows better."""
        own = {key: bound for key in ("lo", "hi") if (bound := getattr(self, key)) is not None}
        return replace(param, **own, **(vars(self.prior) if self.prior else {}))


@dataclass(frozen=True)
class Doubts:
    """How well parameters are known together: `paths` (p,) and their covariance (p, p).

    whole  (p,) what each of them is, or how wide its table is, whichever is more
    """

    paths: tuple[str, ...]
    covariance: Array
    whole: Array


@dataclass(frozen=True)
class Model:
    """Effects by name, and the values of their parameters as "effect.param".

    `use` keeps where a user's own effect came from, seen from `folder`; `about` what the values were fitted to.
    """

    effects: Mapping[str, Effect]
    values: Mapping[str, Value]
    use: Mapping[str, str] = field(default_factory=dict)
    about: Mapping[str, Any] = field(default_factory=dict)
    name: str = "model"
    folder: Path | None = None

    def __repr__(self) -> str:
        """Its equations, each with the values of its parameters."""
        return "\n".join([f"{self.name}: {len(self.effects)} effects", *(self._told(name) for name in self.effects)])

    def _told(self, name: str) -> str:
        effect = self.effects[name]
        values = [f"    {key} = {self.values[f'{name}.{key}']} {param.unit}" for key, param in effect.params.items()]
        return "\n".join(["", f"{name}: {effect.sentence()}", indent(effect.equation(), "    "), *values])

    def __add__(self, effect: type[Effect]) -> "Model":
        """The model with one more effect, at its defaults."""
        return replace(
            self,
            effects={**self.effects, effect.name: effect()},
            values={**self.values, **_defaults(effect)},
        )

    def __sub__(self, name: str) -> "Model":
        """The model without an effect."""
        self._known(name)
        return replace(
            self,
            effects={key: effect for key, effect in self.effects.items() if key != name},
            values={key: value for key, value in self.values.items() if key.partition(".")[0] != name},
        )

    def __getitem__(self, path: str) -> Any:
        """Value of "effect.param"."""
        return self.values[path].value

    def param(self, path: str) -> Param:
        """Declaration of "effect.param", bounds and prior as the model has them."""
        effect, _, key = path.partition(".")
        return self.values[path].over(self.effects[effect].params[key])

    def free(self) -> list[str]:
        """Paths of the parameters that a fit may change."""
        return [path for path, value in self.values.items() if not value.fixed]

    def with_values(self, values: Mapping[str, Any]) -> "Model":
        """The same model with other values, numbers or Value records, at "effect.param"."""
        merged = dict(self.values)
        for path, value in values.items():
            if path not in merged:
                raise SetupError(f"{self.name} has no '{path}'; {nearest(path, merged)}")
            merged[path] = value if isinstance(value, Value) else replace(merged[path], value=value)
        return replace(self, values=merged)

    def terms(self, u: Inputs, rig: Rig) -> Iterator[Term]:
        """All terms of all effects."""
        for name in self.effects:
            yield from self.terms_of(name, u, rig)

    def terms_of(self, name: str, u: Inputs, rig: Rig) -> list[Term]:
        """The terms of one effect; one that asks for what the rig has not, or yields no terms, is an EffectError."""
        p = self.namespace(name)
        for other in self.effects[name].scales:
            setattr(p, other, self.namespace(other) if other in self.effects else None)
        try:
            with np.errstate(all="ignore"):
                terms = list(islice(self.effects[name].terms(p, u, rig), MOST_TERMS + 1))
        except SetupError as error:
            raise self.error(name, str(error)) from error
        except (Exception, SystemExit) as error:
            if name not in self.use:
                raise
            raise self.error(name, f"{_line(error, self.use[name])}{type(error).__name__}: {error}") from error
        if len(terms) > MOST_TERMS:
            raise self.error(name, f"yields more than {MOST_TERMS} terms; does it end?")
        for number, term in enumerate(terms, start=1):
            if not isinstance(term, Term):
                raise self.error(name, f"term {number} is {term!r:.60}; yield Heat(...), Link(...) or another term")
        return terms

    def inputs(self, u: Inputs, rig: Rig) -> Inputs:
        """The inputs, set right by the effects that say what is wrong with them."""
        for name in self.correcting:
            u = self.effects[name].inputs(self.namespace(name), u, rig)
        return u

    def error(self, name: str, what: str) -> EffectError:
        """What is wrong with an effect, in one line that names the model, the effect and a user's own file."""
        own = f" ({self.use[name]})" if name in self.use else ""
        return EffectError(name, f"{self.name}: {name}{own}: {' '.join(what.split())}")

    def namespace(self, name: str) -> SimpleNamespace:
        """Values of one effect's parameters, as attributes."""
        return SimpleNamespace(**{key: self.values[f"{name}.{key}"].value for key in self.effects[name].params})

    def known(self, paths: Sequence[str], covariance: Array) -> "Model":
        """The model with how well these parameters are known, (p, p); correlations are kept to four digits."""
        sd = np.sqrt(np.diag(covariance))
        with np.errstate(invalid="ignore"):  # what nothing tells of goes with nothing
            rho = np.nan_to_num(covariance / np.maximum(np.outer(sd, sd), SMALLEST))
        old = self.about.get("covariance", UNKNOWN)
        stay = [k for k, path in enumerate(old["paths"]) if path not in paths]
        together = scipy.linalg.block_diag(np.asarray(old["correlation"])[np.ix_(stay, stay)], rho).round(DIGITS)
        np.fill_diagonal(together, 1.0)
        names = [*(old["paths"][k] for k in stay), *paths]
        values = {path: replace(self.values[path], sd=float(x)) for path, x in zip(paths, sd, strict=True)}
        kept = {"covariance": {"paths": names, "correlation": together.tolist()}} if names else {}
        return replace(self.with_values(values), about={**self.about, **kept})

    @property
    def doubts(self) -> Doubts:
        """What is known of the parameters that have an sd; together as far as a fit has kept its correlations.

        Not of the expansion coefficient, whose error is a state of the filter.
        """
        paths = tuple(path for path, value in self.values.items() if value.sd and path != EXPANSION)
        sizes = [max(abs(self[path]), self.param(path).sd or 0.0) for path in paths]
        whole = [
            size * (not self.effects[path.partition(".")[0]].apart) for path, size in zip(paths, sizes, strict=True)
        ]
        return Doubts(paths, self.covariance(paths), np.array(whole, dtype=float))

    def covariance(self, paths: Sequence[str]) -> Array:
        """Of the errors of parameters that have an sd, (p, p)."""
        sd, together = np.array([self.values[path].sd for path in paths], dtype=float), np.eye(len(paths))
        kept = self.about.get("covariance", UNKNOWN)
        known = {path: k for k, path in enumerate(kept["paths"]) if path in paths}
        at, of = [paths.index(path) for path in known], list(known.values())
        together[np.ix_(at, at)] = np.asarray(kept["correlation"])[np.ix_(of, of)]
        return together * np.outer(sd, sd)

    def expansion_sd(self, rig: Rig) -> float:
        """How well the expansion coefficient is known, as a share of it: by a fit, else as the rig file says."""
        known = self.values.get(EXPANSION)
        return known.sd if known and known.sd else rig.expansion_tolerance

    def moved_by(self, name: str) -> list[str]:
        """The effects whose terms change with the parameters of this one: itself, and those that scale it; all, where
        it sets inputs right."""
        if name in self.correcting:
            return [*self.effects]
        return [other for other, effect in self.effects.items() if other == name or name in effect.scales]

    @property
    def correcting(self) -> list[str]:
        """Effects that set inputs right."""
        return [name for name, effect in self.effects.items() if type(effect).inputs is not Effect.inputs]

    def _known(self, name: str) -> None:
        if name not in self.effects:
            raise SetupError(f"{self.name} has no effect '{name}'; {nearest(name, self.effects)}")


def model_of(effects: Sequence[type[Effect]], name: str = "model") -> Model:
    """A model of these effects at their defaults."""
    model = Model({}, {}, name=name)
    for effect in effects:
        model = model + effect
    return model


def file_and_class(use: str) -> tuple[str, str]:
    """Of "effects.py:Rub" the file and the class, which is empty where none is named; a folder may have a ':' in it."""
    file, _, cls = use.rpartition(":")
    return (file, cls) if file and cls.isidentifier() else (use, "")


def _line(error: BaseException, use: str) -> str:
    """Where in a user's own file it went wrong."""
    file = Path(file_and_class(use)[0]).name
    lines = [frame.lineno for frame in extract_tb(error.__traceback__) if Path(frame.filename).name == file]
    return f"line {lines[-1]}: " if lines else ""


def _defaults(effect: type[Effect]) -> dict[str, Value]:
    return {f"{effect.name}.{key}": Value(param.value, None, param.fixed) for key, param in effect.params.items()}
