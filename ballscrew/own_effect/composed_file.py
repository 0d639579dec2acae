"""Effects that no catalogue has, as a file of one's own that a model can use."""

from collections.abc import Sequence
from pathlib import Path

from ballscrew.own_effect.class_file import HEAD, imported_names, names_in, tree_of, with_class
from ballscrew.own_effect.named import Named
from estimator.errors import SetupError
from estimator.unknown.composed import Composed
from estimator.unknown.effect_text import VOCABULARY


def taken_in(path: Path) -> list[str]:
    """Names that a file has already; nothing of it runs. A SetupError where no effect can be put behind them."""
    if path.suffix != ".py":
        raise SetupError(f"{path}: effects are Python: take a file whose name ends with .py")
    text = text_in(path)
    names = names_in(tree_of(text, path))
    if foreign := sorted(names & set(VOCABULARY) - imported_names(tree_of(text, path))):
        raise SetupError(
            f"{path}: '{foreign[0]}' is something else there than effects need by that name; take another file"
        )
    return sorted(names)


def write_composed(made: Sequence[Composed], path: Path) -> list[Named]:
    """Put the classes behind what the file has; how a model uses each."""
    for one in made:
        text = text_in(path) or HEAD
        path.write_text(with_class(text, one.text, VOCABULARY, path), encoding="utf-8")
    return [Named(one.effect, path) for one in made]


def text_in(path: Path) -> str:
    """What a file has, "" where there is none yet; a SetupError if it is not UTF-8."""
    try:
        return path.read_text(encoding="utf-8-sig") if path.is_file() else ""
    except UnicodeDecodeError as error:
        raise SetupError(f"{path}: byte {error.start} is not UTF-8; save it as UTF-8, or take another file") from error
