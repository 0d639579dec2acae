"""A rig folder's `rig.toml` into a Rig, with one line for everything that cannot be."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from estimator.errors import SetupError, nearest
from estimator.rig import Channel, Log, Nut, Rig, Screw, Signal, Support
from estimator.rig_folder import fields


def load_rig(folder: Path | str) -> Rig:
    """Read `folder/rig.toml`."""
    folder = Path(folder)
    path = folder / "rig.toml"
    table = fields.load(path)
    known = {"name", "tick_s", "screw", "nut", "supports", "channels", "inputs", "log", "subset_7"}
    for key in table:
        if key not in known:
            raise SetupError(f"{path} has no '{key}'; {nearest(key, known)}")
    for key in ("name", "channels"):
        if key not in table:
            raise SetupError(f"{path}: '{key}' is missing")
    if isinstance(tick_s := table.get("tick_s", 1.0), bool) or not isinstance(tick_s, (int, float)):
        raise SetupError(f"{path}: tick_s: expected a number, got {tick_s!r}")
    rig = Rig(
        name=str(table["name"]),
        tick_s=float(tick_s),
        channels=_records(Channel, table["channels"], f"{path}: channels"),
        inputs=_records(Signal, table.get("inputs", {}), f"{path}: inputs"),
        screw=_optional(Screw, table, "screw", path),
        nut=_optional(Nut, table, "nut", path),
        supports=_records(Support, table.get("supports", {}), f"{path}: supports"),
        log=_optional(Log, table, "log", path) or Log(),
        subset_7=fields.items(table.get("subset_7", []), str, f"{path}: subset_7"),
        folder=folder,
    )
    for wrong in _contradictions(rig):
        raise SetupError(f"{path}: {wrong}")
    return rig


def _contradictions(rig: Rig) -> Iterator[str]:
    """What cannot be, one sentence each: lengths the wrong way round, places outside, parts that need another."""
    if not rig.tick_s > 0:
        yield "tick_s must be above 0"
    for name, signal in [*rig.channels.items(), *rig.inputs.items()]:
        if not signal.lo < signal.hi:
            yield f"{name}: lo = {signal.lo:g} is not below hi = {signal.hi:g}"
    for name, channel in rig.channels.items():
        if channel.at_mm is not None and channel.node is not None:
            yield f"channels.{name} has both at_mm and node; a thermometer is in one place"
    for name in rig.subset_7:
        if name not in rig.thermometers:
            yield f"subset_7: no thermometer '{name}'; {nearest(name, rig.thermometers)}"
    if missing := [name for name in ("position", "speed") if rig.nut and name not in rig.inputs]:
        yield f"[nut] needs the input '{missing[0]}'; add it to [inputs] or leave the nut out"
    yield from _off_the_screw(rig)


def _off_the_screw(rig: Rig) -> Iterator[str]:
    screw = rig.screw
    places = {f"channels.{name}.at_mm": c.at_mm for name, c in rig.channels.items() if c.at_mm is not None}
    places |= {f"supports.{name}.at_mm": support.at_mm for name, support in rig.supports.items()}
    if screw is None:
        for key in places:
            yield f"{key} is a place on the screw, but there is no [screw]"
        return
    if not (screw.from_mm < screw.to_mm and 0 <= screw.bore_mm < screw.outer_mm and screw.cells >= 2):
        yield "screw: from_mm must be below to_mm, bore_mm below outer_mm, and cells at least 2"
    places |= {f"screw.knots_mm: {place:g}": place for place in screw.knots_mm}
    places |= dict(zip(("screw.span_from_mm", "screw.span_to_mm"), screw.span_mm, strict=True))
    for key, place in places.items():
        if not screw.from_mm <= place <= screw.to_mm:
            yield f"{key} = {place:g} is outside the screw, {screw.from_mm:g} ... {screw.to_mm:g} mm"


def _optional(cls: type, table: Mapping[str, Any], key: str, path: Path) -> Any:
    return fields.record(cls, table[key], f"{path}: {key}") if key in table else None


def _records(cls: type, table: Any, place: str) -> dict[str, Any]:
    if not isinstance(table, Mapping):
        raise SetupError(f"{place}: expected one table per name")
    return {name: fields.record(cls, entry, f"{place}.{name}") for name, entry in table.items()}
