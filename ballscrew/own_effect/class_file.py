"""A file of Python gets one more class at its end, and the imports that it lacks for it. Nothing of it runs."""

import ast
from collections.abc import Mapping
from pathlib import Path

from estimator.errors import SetupError

HEAD = '"""Effects of this rig that the catalogue does not have."""\n'  # of a new file


def with_class(text: str, added: str, vocabulary: Mapping[str, str], path: Path) -> str:
    """A file's text with the class `added`; `vocabulary`: the module of each name that may have to be imported."""
    tree = tree_of(text, path)
    (own,) = (node.name for node in ast.parse(added).body if isinstance(node, ast.ClassDef))
    used = {node.id for node in ast.walk(ast.parse(added)) if isinstance(node, ast.Name)} & set(vocabulary)
    taken = names_in(tree)
    for name in (own, *sorted(used - imported_names(tree))):
        if name in taken:
            raise SetupError(f"{path}: '{name}' is there already; choose another name, or another file with -o")
    lines = text.rstrip().split("\n")
    for name in (name for name in vocabulary if name in used - imported_names(tree)):
        _import(lines, vocabulary[name], name)
    return "\n".join([*lines, "", "", added])


def tree_of(text: str, path: Path) -> ast.Module:
    """A file's text as Python."""
    try:
        return ast.parse(text)
    except SyntaxError as error:
        where = f"line {error.lineno}" if error.lineno else "this"
        raise SetupError(f"{path}: {where} is not Python: {error.msg}; correct it first") from error
    except ValueError as error:  # of a null byte, in some versions of Python
        raise SetupError(f"{path}: this is not Python: {error}; correct it first") from error


def names_in(tree: ast.Module) -> set[str]:
    """Every name that a file gives something at its top level."""
    given = {node.name for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    targets = [t for node in tree.body if isinstance(node, ast.Assign) for t in node.targets]
    targets += [node.target for node in tree.body if isinstance(node, ast.AnnAssign)]
    given |= {each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)}
    return given | imported_names(tree)


def imported_names(tree: ast.Module) -> set[str]:
    """Names that a file imports at its top level."""
    imports = [node for node in tree.body if isinstance(node, (ast.Import, ast.ImportFrom))]
    return {alias.asname or alias.name for node in imports for alias in node.names}


def _import(lines: list[str], module: str, name: str) -> None:
    """Import a name: beside others of its module where those stand in one line, else in a line behind all imports."""
    body = ast.parse("\n".join(lines)).body
    imports = [node for node in body if isinstance(node, (ast.Import, ast.ImportFrom))]
    for node in imports:
        line = lines[node.lineno - 1]
        alone = node.lineno == node.end_lineno and not set("#;*") & set(line)
        if isinstance(node, ast.ImportFrom) and node.module == module and alone:
            names = [ast.unparse(alias) for alias in node.names]
            lines[node.lineno - 1] = f"from {module} import {', '.join(sorted([*names, name], key=_rank))}"
            return
    head = [node for node in body[:1] if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)]
    at = max((node.end_lineno or 0 for node in (*head, *imports)), default=0)
    apart = bool(lines[:at]) and (not imports or isinstance(imports[-1], ast.Import))
    line = f"import numpy as {name}" if module == "numpy" else f"from {module} import {name}"
    lines[at:at] = ["", line] if apart else [line]


def _rank(name: str) -> tuple[int, str]:
    """Constants first, then classes, then the rest, as import sorters have it."""
    return (0 if name.isupper() else 1 if name[0].isupper() else 2), name
