"""A rig folder's `rig.toml` into a Rig, with one line for everything that cannot be."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from estimator.errors import SetupError, nearest
from estimator.rig import Channel, Rig, Signal
from estimator.rig_folder import fields
from estimator.rig_folder.bounds import BOUNDS, brief
from estimator.rig_folder.contradictions import contradictions
from estimator.rig_log import Log
from estimator.screw import Bed, Nut, Screw, Support

MOST = {"channels": 200, "inputs": 200, "supports": 20}  # tables of a kind
ZERO_C_IN_K = 273.15
RESERVED = {"screw", "start", "elongation"}  # what terms of effects call so


def load_rig(folder: Path | str) -> Rig:
    """Read `folder/rig.toml`, which may be named itself."""
    folder = Path(folder)
    folder = folder.parent if folder.name == "rig.toml" else folder
    path = folder / "rig.toml"
    table = fields.load(path)
    known = {f.name for f in dataclasses.fields(Rig)} - {"folder"}
    for key in table:
        if key not in known:
            raise SetupError(f"{path} has no {brief(key)}; {nearest(key, known)}")
    for key in ("name", "channels"):
        if key not in table:
            raise SetupError(f"{path}: '{key}' is missing")
    rig = Rig(
        name=fields.checked(table["name"], str, f"{path}: name"),
        tick_s=_number(table, "tick_s", 1.0, path),
        channels=_records(Channel, table, "channels", path),
        inputs=_records(Signal, table, "inputs", path),
        screw=_optional(Screw, table, "screw", path),
        nut=_optional(Nut, table, "nut", path),
        bed=_optional(Bed, table, "bed", path),
        supports=_records(Support, table, "supports", path),
        log=_optional(Log, table, "log", path) or Log(),
        subset_7=fields.checked(table.get("subset_7", []), tuple[str, ...], f"{path}: subset_7"),
        zero_C=_number(table, "zero_C", None, path),
        zero_sd_K=_number(table, "zero_sd_K", 0.0, path),
        folder=folder,
    )
    for wrong in contradictions(rig):
        raise SetupError(f"{path}: {wrong}")
    return rig


def _number(table: Mapping[str, Any], key: str, default: float | None, path: Path) -> Any:
    """A number at the top of the file, in its bounds, or its default."""
    return fields.checked(table[key], float, f"{path}: {key}", BOUNDS[Rig][key]) if key in table else default


def _optional(cls: type, table: Mapping[str, Any], key: str, path: Path) -> Any:
    return fields.record(cls, table[key], f"{path}: {key}") if key in table else None


def _records(cls: type, table: Mapping[str, Any], key: str, path: Path) -> dict[str, Any]:
    """The tables of a kind, by name."""
    entries, place = table.get(key, {}), f"{path}: {key}"
    if not isinstance(entries, Mapping):
        raise SetupError(f"{place}: expected one table per name")
    if len(entries) > MOST[key]:
        raise SetupError(f"{place}: {len(entries)} of them; at most {MOST[key]}")
    for name in entries:
        if name in RESERVED or name != name.strip() or not name.isprintable() or not 0 < len(name) <= fields.SHORT:
            raise SetupError(f"{place}: {brief(name)} cannot be a name; take one to {fields.SHORT} letters")
    return {name: _in_degC(fields.record(cls, entry, f"{place}.{name}")) for name, entry in entries.items()}


def _in_degC(signal: Any) -> Any:
    """A signal in K as one in degC; its range too, where the file says one."""
    if getattr(signal, "unit", "") != "K":
        return signal
    default = Signal()
    lo = signal.lo if signal.lo == default.lo else signal.lo - ZERO_C_IN_K
    hi = signal.hi if signal.hi == default.hi else signal.hi - ZERO_C_IN_K
    return dataclasses.replace(signal, unit="degC", offset=signal.offset - ZERO_C_IN_K, lo=lo, hi=hi)
