"""The project's own errors: each message is one line that names the thing, the place and the fix.

    BallscrewError
    ├── InputError    a recording or log could not be used           exit 1
    └── SetupError    wrong rig, model, effect file or usage         exit 2
        └── EffectError    an effect of the model that says something impossible

Anything else that reaches the command line is a bug and keeps its traceback.
"""

from collections.abc import Iterable
from difflib import get_close_matches


class BallscrewError(Exception):
    """Ours: shown as one line on the terminal."""

    exit_code = 1


class InputError(BallscrewError):
    """A recording or log that cannot be used."""

    exit_code = 1


class SetupError(BallscrewError):
    """A rig, model or effect file, or a command line, that says something impossible."""

    exit_code = 2


class EffectError(SetupError):
    """An effect of a model that says something impossible, perhaps only at some ticks; `effect` is its name."""

    def __init__(self, effect: str, message: str) -> None:
        super().__init__(message)
        self.effect = effect

    def __reduce__(self) -> "tuple[type[EffectError], tuple[str, str]]":
        return EffectError, (self.effect, str(self))  # as it travels between processes


def nearest(word: str, known: Iterable[str]) -> str:
    """Say which known word was probably meant, or which there are: the last part of an error line."""
    known = sorted(known)
    close = get_close_matches(word, known, n=1)
    return f"did you mean '{close[0]}'?" if close else f"known: {', '.join(known)}"
