"""A model: a list of effects with the values of their parameters; composed with + and -, kept as TOML."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import tomlkit

from estimator import fields
from estimator.effect import Effect, Param
from estimator.effects import CATALOGUE
from estimator.errors import SetupError, nearest
from estimator.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import Term


@dataclass(frozen=True)
class Value:
    """A parameter's value in one model, with its standard deviation where it was fitted."""

    value: Any
    sd: float | None = None
    fixed: bool = False


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

    def __add__(self, effect: type[Effect]) -> Model:
        """The model with one more effect, at its defaults."""
        return replace(
            self,
            effects={**self.effects, effect.name: effect()},
            values={**self.values, **_defaults(effect)},
        )

    def __sub__(self, name: str) -> Model:
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
        """Declaration of "effect.param"."""
        effect, _, key = path.partition(".")
        return self.effects[effect].params[key]

    def free(self) -> list[str]:
        """Paths of the parameters that a fit may change."""
        return [path for path, value in self.values.items() if not value.fixed]

    def with_values(self, values: Mapping[str, Any]) -> Model:
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

    def terms_of(self, name: str, u: Inputs, rig: Rig) -> Iterator[Term]:
        """The terms of one effect; one that asks for what the rig has not is a SetupError that names the effect."""
        p = self.namespace(name)
        for other in self.effects[name].scales:
            setattr(p, other, self.namespace(other) if other in self.effects else None)
        try:
            yield from self.effects[name].terms(p, u, rig)
        except SetupError as error:
            raise SetupError(f"{self.name}: {name}: {error}") from error
        except Exception as error:
            if name not in self.use:
                raise
            raise SetupError(f"{self.name}: {name} ({self.use[name]}): {type(error).__name__}: {error}") from error

    def namespace(self, name: str) -> SimpleNamespace:
        """Values of one effect's parameters, as attributes."""
        effect = self.effects[name]
        return effect.namespace({key: self.values[f"{name}.{key}"].value for key in effect.params})

    def moved_by(self, name: str) -> list[str]:
        """The effects whose terms change with the parameters of this one: itself, and those that scale it."""
        return [other for other, effect in self.effects.items() if other == name or name in effect.scales]

    def _known(self, name: str) -> None:
        if name not in self.effects:
            raise SetupError(f"{self.name} has no effect '{name}'; {nearest(name, self.effects)}")


def model_of(effects: Sequence[type[Effect]], name: str = "model") -> Model:
    """A model of these effects at their defaults."""
    model = Model({}, {}, name=name)
    for effect in effects:
        model = model + effect
    return model


def load_model(path: Path) -> Model:
    """Read a model TOML: one table an effect; each parameter a number or {value, sd, fixed}.

    `use = "effects.py:CoolantJet"` in a table names a user's own effect: that file is Python, and runs.
    """
    table = fields.load(path)
    about = table.pop("about", {})
    if not isinstance(about, Mapping) or not isinstance(about.get("fitted_on", {}), Mapping):
        raise SetupError(f"{path}: 'about' is what a fit writes: a table, with a table 'fitted_on'")
    model = Model({}, {}, about=about, name=path.name)
    use = {}
    for name, entry in table.items():
        if not isinstance(entry, Mapping):
            raise SetupError(f"{path}: '{name}' should be a table, one for each effect")
        own = entry.get("use")
        if own is not None:
            use[name] = own
        effect = own_effect(str(own), path.parent) if own else _catalogued(name, path)
        if effect.name != name:
            raise SetupError(f"{path}: {name}: the effect's name is '{effect.name}'; call the table so")
        model = model + effect
        model = model.with_values(_values(effect, entry, f"{path}: {name}"))
    return replace(model, use=use, folder=path.parent)


def save_model(model: Model, path: Path) -> None:
    """Write a model TOML that `load_model` reads back unchanged, in any folder, with units as comments."""
    document = tomlkit.document()
    if model.about:
        document.add("about", tomlkit.item(dict(model.about)))
    for name, effect in model.effects.items():
        table = tomlkit.table()
        table.comment(effect.sentence())
        if name in model.use:
            table.add("use", _seen_from(path.parent, model, name))
        for key, param in effect.params.items():
            item = _item(model.values[f"{name}.{key}"], param)
            table.add(key, item)
            item.comment(param.unit)
        document.add(name, table)
    path.write_text(tomlkit.dumps(document))


def _seen_from(folder: Path, model: Model, name: str) -> str:
    """Where an own effect is, for a model file in `folder`."""
    file, _, cls = model.use[name].partition(":")
    if model.folder is None:
        return model.use[name]
    return f"{Path(os.path.relpath(model.folder / file, folder)).as_posix()}:{cls}"


def _item(value: Value, param: Param) -> tomlkit.items.Item:
    number = float(f"{value.value:.6g}")
    if value.sd is None and value.fixed == param.fixed:
        return tomlkit.item(number)
    table = tomlkit.inline_table()
    table.add("value", number)
    if value.sd is not None:
        table.add("sd", float(f"{value.sd:.3g}"))
    if value.fixed != param.fixed:
        table.add("fixed", value.fixed)
    return table


def _defaults(effect: type[Effect]) -> dict[str, Value]:
    return {f"{effect.name}.{key}": Value(param.value, None, param.fixed) for key, param in effect.params.items()}


def _catalogued(name: str, path: Path) -> type[Effect]:
    if name not in CATALOGUE:
        raise SetupError(f"{path}: no effect '{name}'; {nearest(name, CATALOGUE)}")
    return CATALOGUE[name]


def _values(effect: type[Effect], entry: Mapping[str, Any], place: str) -> dict[str, Value]:
    values = {}
    for key, item in entry.items():
        if key == "use":
            continue
        if key not in effect.params:
            raise SetupError(f"{place} has no '{key}'; {nearest(key, effect.params)}")
        param = effect.params[key]
        default = Value(param.value, None, param.fixed)
        if isinstance(item, Mapping):
            value = fields.record(Value, {"value": param.value, "fixed": param.fixed, **item}, f"{place}.{key}")
        else:
            value = replace(default, value=item)
        if isinstance(value.value, bool) or not isinstance(value.value, (int, float)):
            raise SetupError(f"{place}.{key}: expected a number, got {value.value!r}")
        if not param.lo <= value.value <= param.hi:
            raise SetupError(f"{place}.{key} = {value.value:g} {param.unit} is outside {param.lo:g} ... {param.hi:g}")
        values[f"{effect.name}.{key}"] = replace(value, value=float(value.value))
    return values


def own_effect(use: str, folder: Path) -> type[Effect]:
    """Import `file.py:Class`, seen from a folder. Runs the user's code: only for a file that is named."""
    file, _, cls = use.partition(":")
    path = folder / file
    if not cls or not path.is_file():
        raise SetupError(f'{path}: no such effect file; write use = "effects.py:ClassName"')
    found = own_effects(path)
    if cls not in found:
        raise SetupError(f"{path} has no effect '{cls}'; {nearest(cls, found)}")
    return found[cls]


def own_effects(path: Path) -> dict[str, type[Effect]]:
    """Run a file of a user's own and find the effects in it, by class name; those it imports are there too."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise SetupError(f"{path}: {type(error).__name__}: {error}") from error
    return {k: v for k, v in vars(module).items() if isinstance(v, type) and issubclass(v, Effect) and v is not Effect}
