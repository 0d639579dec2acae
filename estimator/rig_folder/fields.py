"""TOML tables into frozen records, with errors that name the file, the key and the fix."""

import dataclasses
import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import UnionType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

from estimator.errors import SetupError, nearest
from estimator.rig_folder.bounds import BOUNDS, Bound, brief

Record = TypeVar("Record")

LARGEST = 1_000_000  # bytes of a file
LONGEST, SHORT = 200, 64  # characters of a text (or entries of a list), of a name
KINDS = {int: "int", str: "str", bool: "bool"}
_hints = cache(get_type_hints)  # of a class of ours, asked for each of a model's hundred values


def load(path: Path) -> dict[str, Any]:
    """Parse a TOML file in UTF-8, with or without a byte order mark; else a SetupError naming the place."""
    try:
        if not path.is_file():
            raise SetupError(f"{path}: {'not a file' if path.exists() else 'no such file'}")
        if (size := path.stat().st_size) > LARGEST:
            raise SetupError(f"{path}: {size} bytes; a rig or a model has at most {LARGEST}")
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise SetupError(f"{path}: not TOML: {error}; save it as UTF-8") from None
    except (ValueError, RecursionError) as error:
        raise SetupError(f"{path}: not TOML: {' '.join(str(error).split())}") from None
    except OSError as error:
        raise SetupError(f"{path}: cannot be read: {error.strerror}") from None


def record(cls: type[Record], table: Any, place: str) -> Record:
    """Build the dataclass `cls` from a table: every key known, none missing, every value of its kind and in bounds."""
    fields = {f.name: f for f in dataclasses.fields(cls) if f.init}  # type: ignore[arg-type]
    if not isinstance(table, Mapping):
        raise SetupError(f"{place}: expected a table with {', '.join(fields)}")
    for key in table:
        if key not in fields:
            raise SetupError(f"{place} has no {brief(key)}; {nearest(key, fields)}")
    for name, field in fields.items():
        required = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        if required and name not in table:
            raise SetupError(f"{place}: '{name}' is missing")
    hints, bounds = _hints(cls), BOUNDS.get(cls, {})  # type: ignore[arg-type]
    return cls(**{k: checked(value, hints[k], f"{place}.{k}", bounds.get(k)) for k, value in table.items()})


def checked(value: Any, hint: Any, place: str, bound: Bound | None = None) -> Any:
    """A value of the kind that a type hint asks for, in its bounds; a list as a tuple, a table as a record."""
    kinds = get_args(hint) if isinstance(hint, UnionType) else (hint,)
    lists = [kind for kind in kinds if get_origin(kind) is tuple]
    if lists and (isinstance(value, list) or len(kinds) == 1):
        return _items(value, get_args(lists[0])[0], place, bound)
    if tables := [kind for kind in kinds if isinstance(kind, type) and dataclasses.is_dataclass(kind)]:
        return record(tables[0], value, place)
    if float in kinds:
        return _number(value, place, bound)
    expected = [word for kind, word in KINDS.items() if kind in kinds]
    if expected and type(value) not in kinds:
        raise SetupError(f"{place}: expected {' or '.join(expected)}, got {brief(value)}")
    if isinstance(value, str):
        return _text(value, place)
    if bound is not None:
        bound.check(value, place)
    return value


def _items(value: Any, kind: type, place: str, bound: Bound | None) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise SetupError(f"{place}: expected a list in [ ], got {brief(value)}")
    if len(value) > LONGEST:
        raise SetupError(f"{place}: {len(value)} entries; at most {LONGEST}")
    return tuple(checked(entry, kind, place, bound) for entry in value)


def _number(value: Any, place: str, bound: Bound | None) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise SetupError(f"{place}: expected a number, got {brief(value)}")
    if bound is not None:
        bound.check(value, place)
    return float(value)


def _text(value: str, place: str) -> str:
    if not value.strip() or not value.isprintable() or len(value) > LONGEST:
        raise SetupError(f"{place}: expected 1 to {LONGEST} characters in one line, got {brief(value)}")
    return value
