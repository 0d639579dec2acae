"""A rig folder's `model.toml` into a Model and back, effects of one's own included."""

import importlib.util
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from estimator.effect import Effect, Param
from estimator.effects import CATALOGUE
from estimator.errors import SetupError, nearest
from estimator.model import Model, Value, file_and_class
from estimator.rig_folder import fields


@dataclass(frozen=True)
class Together:
    """How the errors of fitted parameters go together: their paths (p,), their correlations (p, p)."""

    paths: tuple[str, ...]
    correlation: tuple[tuple[float, ...], ...]


def load_model(path: Path | str) -> Model:
    """Read a model TOML: one table an effect; each parameter a number or {value, sd, fixed, prior, lo, hi}.

    `use = "effects.py:CoolantJet"` in a table names a user's own effect: that file is Python, and runs.
    """
    path = Path(path)
    table = fields.load(path)
    about = table.pop("about", {})
    if not isinstance(about, Mapping) or not isinstance(about.get("fitted_on", {}), Mapping):
        raise SetupError(f"{path}: 'about' is what a fit writes: a table, with a table 'fitted_on'")
    if "covariance" in about:
        about = {**about, "covariance": _together(about["covariance"], f"{path}: about.covariance")}
    model = Model({}, {}, about=about, name=path.name)
    use = {}
    for name, entry in table.items():
        if not isinstance(entry, Mapping):
            raise SetupError(f"{path}: '{name}' should be a table, one for each effect")
        if "use" in entry:
            use[name] = fields.checked(entry["use"], str, f"{path}: {name}.use")
        effect = own_effect(use[name], path.parent) if name in use else _catalogued(name, path)
        if effect.name != name:
            raise SetupError(f"{path}: {name}: the effect's name is '{effect.name}'; call the table so")
        model = model + effect
        model = model.with_values(_values(effect, entry, f"{path}: {name}"))
    return replace(model, use=use, folder=path.parent)


def save_model(model: Model, path: Path) -> None:
    """Write a model TOML that `load_model` reads back unchanged, in any folder, with units as comments."""
    document = tomlkit.document()
    if model.about:
        about = tomlkit.item(dict(model.about))
        if "covariance" in about:
            about["covariance"]["correlation"].multiline(True)
        document.add("about", about)
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
    path.write_text(tomlkit.dumps(document), encoding="utf-8")


def _seen_from(folder: Path, model: Model, name: str) -> str:
    """Where an own effect is, for a model file in `folder`."""
    file, cls = file_and_class(model.use[name])
    if model.folder is None:
        return model.use[name]
    return f"{Path(os.path.relpath(model.folder / file, folder)).as_posix()}:{cls}"


def _item(value: Value, param: Param) -> tomlkit.items.Item:
    said: dict[str, Any] = {"value": float(f"{value.value:.6g}")}
    if value.sd is not None:
        said["sd"] = float(f"{value.sd:.3g}")
    if value.fixed != param.fixed:
        said["fixed"] = value.fixed
    if value.prior is not None:
        said["prior"] = vars(value.prior)
    said |= {key: bound for key in ("lo", "hi") if (bound := getattr(value, key)) is not None}
    if len(said) == 1:
        return tomlkit.item(said["value"])
    table = tomlkit.inline_table()
    table.update(said)
    return table


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
        values[f"{effect.name}.{key}"] = _value(item, effect.params[key], f"{place}.{key}")
    return values


def _together(entry: Any, place: str) -> dict[str, Any]:
    """What a fit wrote of correlations; the nearest that can be, where rounding made a variance negative."""
    told = fields.record(Together, entry, place)
    p = len(told.paths)
    if p == 0 or {len(told.correlation), *map(len, told.correlation)} != {p}:
        raise SetupError(f"{place}.correlation: expected {p} rows of {p} numbers, as paths has {p}; fit again")
    rho = np.array(told.correlation)
    if not (np.array_equal(rho, rho.T) and (np.diag(rho) == 1.0).all() and (np.abs(rho) <= 1.0).all()):
        raise SetupError(f"{place}.correlation: expected 1 from a corner to the other, alike on both sides; fit again")
    rates, ways = np.linalg.eigh(rho)
    if rates[0] < 0.0:
        root = ways * np.sqrt(np.maximum(rates, 0.0))
        root /= np.linalg.norm(root, axis=1)[:, None]
        rho = root @ root.T
    return {"paths": list(told.paths), "correlation": rho.tolist()}


def _value(item: Any, param: Param, place: str) -> Value:
    """A parameter's entry, a number or a table, with a value inside its bounds, and its prior's too."""
    entry = item if isinstance(item, Mapping) else {"value": item}
    value = fields.record(Value, {"value": param.value, "fixed": param.fixed, **entry}, place)
    if isinstance(value.value, bool) or not isinstance(value.value, (int, float)):
        raise SetupError(f"{place}: expected a number, got {value.value!r}")
    param = value.over(param)
    if not param.lo < param.hi:
        raise SetupError(f"{place}: lo = {param.lo:g} is not below hi = {param.hi:g} {param.unit}")
    for at, number in (("", value.value), (".prior.value", value.prior.value if value.prior else value.value)):
        if not param.lo <= number <= param.hi:
            raise SetupError(f"{place}{at} = {number:g} {param.unit} is outside {param.lo:g} ... {param.hi:g}")
    return replace(value, value=float(value.value))


def own_effect(use: str, folder: Path) -> type[Effect]:
    """Import `file.py:Class`, seen from a folder. Runs the user's code: only for a file that is named."""
    file, cls = file_and_class(use)
    path = folder / file
    if not cls or not path.is_file():
        raise SetupError(f'{path}: no such effect file; write use = "effects.py:ClassName"')
    found = own_effects(path)
    if cls not in found:
        known = nearest(cls, found) if found else "it has none: write a class that is an Effect"
        raise SetupError(f"{path} has no effect '{cls}'; {known}")
    return found[cls]


def own_effects(path: Path) -> dict[str, type[Effect]]:
    """Run a file of a user's own and find the effects in it, by class name; those it imports are there too."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except SetupError as error:
        raise SetupError(f"{path}: {error}") from error
    except (Exception, SystemExit) as error:
        raise SetupError(f"{path}: {type(error).__name__}: {' '.join(str(error).split())}") from error
    return {k: v for k, v in vars(module).items() if isinstance(v, type) and issubclass(v, Effect) and v is not Effect}
