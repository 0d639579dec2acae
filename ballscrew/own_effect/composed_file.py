"""Effects that no catalogue has, as a file of one's own that a model can use."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from pathlib import Path

from ballscrew.own_effect.class_file import HEAD, with_class
from ballscrew.own_effect.named import Named
from estimator.errors import SetupError
from estimator.unknown.composed import Composed
from estimator.unknown.effect_text import VOCABULARY


def taken_in(path: Path) -> list[str]:
    """Names of the classes and functions that a file has already; nothing of it runs."""
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    try:
        body = ast.parse(text).body
    except SyntaxError as error:
        raise SetupError(f"{path}: line {error.lineno} is not Python: {error.msg}; correct it first") from error
    return [node.name for node in body if isinstance(node, (ast.ClassDef, ast.FunctionDef))]


def write_composed(made: Sequence[Composed], path: Path) -> list[Named]:
    """Put the classes behind what the file has; how a model uses each."""
    for one in made:
        text = path.read_text(encoding="utf-8") if path.is_file() else HEAD
        path.write_text(with_class(text, one.text, VOCABULARY, path), encoding="utf-8")
    return [Named(one.effect, path) for one in made]
