"""TOML tables into frozen records, with errors that name the file, the key and the fix."""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

from estimator.errors import SetupError, nearest

Record = TypeVar("Record")


def load(path: Path) -> dict[str, Any]:
    """Parse a TOML file; a missing or malformed one is a SetupError naming the place."""
    try:
        with path.open("rb") as file:
            return tomllib.load(file)
    except FileNotFoundError:
        raise SetupError(f"{path}: no such file") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SetupError(f"{path}: not TOML: {error}") from None
    except OSError as error:
        raise SetupError(f"{path}: cannot be read: {error.strerror}") from None


def record(cls: type[Record], table: Any, place: str) -> Record:
    """Build the dataclass `cls` from a table: every key known, none missing, every value of the declared kind."""
    if not isinstance(table, Mapping):
        raise SetupError(f"{place}: expected a table with {', '.join(_names(cls))}")
    fields = {f.name: f for f in dataclasses.fields(cls) if f.init}  # type: ignore[arg-type]
    for key in table:
        if key not in fields:
            raise SetupError(f"{place} has no '{key}'; {nearest(key, fields)}")
    for name, field in fields.items():
        required = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        if required and name not in table:
            raise SetupError(f"{place}: '{name}' is missing")
    hints = get_type_hints(cls)
    return cls(**{key: _value(value, hints[key], f"{place}.{key}") for key, value in table.items()})


def _names(cls: type) -> list[str]:
    return [f.name for f in dataclasses.fields(cls)]


def _value(value: Any, hint: Any, place: str) -> Any:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if hint in (float, float | None):
        if not number:
            raise SetupError(f"{place}: expected a number, got {value!r}")
        return float(value)
    if hint in (int, str, bool, str | None) and not isinstance(value, (str if hint == str | None else hint)):
        raise SetupError(f"{place}: expected {getattr(hint, '__name__', 'str')}, got {value!r}")
    if get_origin(hint) is tuple:
        return items(value, get_args(hint)[0], place)
    return tuple(value) if isinstance(value, list) else value


def items(value: Any, kind: type, place: str) -> tuple[Any, ...]:
    """A TOML list whose entries are all of one kind, as a tuple."""
    if not isinstance(value, list):
        raise SetupError(f"{place}: expected a list in [ ], got {value!r}")
    return tuple(_value(entry, kind, place) for entry in value)
