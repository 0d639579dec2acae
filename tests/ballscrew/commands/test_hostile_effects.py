"""A model with an effect of one's own that is wrong: each command ends with one line that names it, and exit 1 or 2."""

import shutil
import warnings
from pathlib import Path

import pytest

from tests.conftest import ROD, ballscrew

HEAD = '''import numpy as np

from estimator.effect import Effect, Param
from estimator.terms import SCREW, Heat, Link, Read, Store


class Mine(Effect):
    """A jet cools the rod all along.

    q = -P
    """

    power = Param(5.0, "W", lo=0.0, hi=50.0, null=0.0, source="a guess")

    def terms(self, p, u, rig):
        '''
BODY = "m.toml: mine (mine.py:Mine): "
WRONG = {  # by what terms does: what is said
    "yield 5.0": BODY + "term 1 is 5.0; yield Heat(...), Link(...) or another term",
    "return": BODY + "TypeError: 'NoneType' object is not iterable",
    "yield from ()": BODY + "yields no term; yield one with 0 rather than none",
    "yield Heat(SCREW, np.ones(7))": BODY + "term 1, Heat of screw: q has the shape (7,), must be",
    "yield Heat('nutt', p.power)": BODY + "a Heat is in 'nutt', which no effect of the model stores; known: screw",
    "yield Link(SCREW, 'ambient', -p.power)": BODY + "term 1, Link of screw - ambient: g is -5, must be 0",
    "yield Store('body', 0.0, 1.0)": BODY + "term 1, Store of body: capacity is 0, must be",
    "yield Heat(SCREW, u['heeter'])": BODY + "needs the input 'heeter', which rig.toml has not in [inputs]; did you",
    "yield Heat(SCREW, 1 / 0)": BODY + "line 16: ZeroDivisionError: division by zero",
    "raise SystemExit(0)": BODY + "line 16: SystemExit: 0",
    "yield from self.terms(p, u, rig)": BODY + "line 16: RecursionError: maximum recursion depth exceeded",
    "while True: yield Heat(SCREW, 0.0)": BODY + "yields more than 2000 terms; does it end?",
    "u['heater'][:] = 0.0": BODY + "line 16: ValueError: assignment destination is read-only",
    "yield Heat(SCREW, u['heater'].max() / 1e4)": BODY + "term 1, Heat of screw: q of a tick changes with",
}  # fmt: skip
AT_SOME = {  # what only the recording shows: a heater that is off makes 0/0
    "yield Heat(SCREW, p.power * u['heater'] / u['heater'])": "term 1, Heat of screw: q is nan at 0 s (tick 0)",
    "yield Read('TC1', {}, 0.0, np.where(abs(u.motion.time_s - 200.0) < 100.0, np.nan, 0.0))": "term 1, Read of TC1: "
    "offset is nan at 1",
}
FILES = {  # by the file's text: what is said
    "": "mine.py has no effect 'Mine'; it has none: write a class that is an Effect",
    "import nosuchmodule\n": "mine.py: ModuleNotFoundError: No module named 'nosuchmodule'",
    "def (:\n": "mine.py: SyntaxError: invalid syntax (mine.py, line 1)",
    "raise RuntimeError('a\\nb')\n": "mine.py: RuntimeError: a b",
    HEAD.replace("    def terms(self, p, u, rig):\n        ", ""): BODY + "effect mine: 'terms' is missing",
    HEAD.replace("lo=0.0", "lo=90.0") + "pass\n": "mine.py: effect Mine: power: lo = 90 is not below hi = 50",
    HEAD.replace("null=0.0", "null=float('nan')") + "pass\n": "mine.py: effect Mine: power: null is nan, must be a n",
}


def folder_with(tmp_path: Path, text: str) -> Path:
    for name in ("rig.toml", "check.csv", "effects.py"):
        shutil.copy(ROD / name, tmp_path)
    (tmp_path / "mine.py").write_text(text)
    model = (ROD / "model.toml").read_text() + '\n[mine]\nuse = "mine.py:Mine"\n'
    (tmp_path / "m.toml").write_text(model)
    return tmp_path


def refused(folder: Path, *words: object) -> str:
    """What a command says that must end in one line."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        status, _, err = ballscrew(*words, "--quiet")
    assert status == 2
    (line,) = err.splitlines()
    assert line.startswith("error: ")
    return line.removeprefix("error: ").removeprefix(f"{folder}/")


@pytest.mark.parametrize(("text", "says"), ({HEAD + body + "\n": says for body, says in WRONG.items()} | FILES).items())
def test_what_can_never_be_is_said_before_anything_else(tmp_path, text, says):
    folder = folder_with(tmp_path, text)
    for words in (
        ("show", folder / "m.toml"),
        ("review", folder / "check.csv", "--model", folder / "m.toml"),
        ("live", "--interface", "virtual", "--channel", "x", "--rig", folder, "--model", folder / "m.toml"),
    ):
        assert refused(folder, *words).startswith(says)


@pytest.mark.parametrize("command", ["review", "fit", "tune", "diagnose", "suggest"])
@pytest.mark.parametrize(("body", "says"), AT_SOME.items())
def test_what_only_some_ticks_make_impossible_is_named_with_the_tick(tmp_path, command, body, says):
    folder = folder_with(tmp_path, HEAD + body + "\n")
    words = (command, folder / "check.csv", "--model", folder / "m.toml")
    out = ("-o", folder / "out.toml") if command in ("fit", "tune") else ()
    assert refused(folder, *words, *out).startswith(BODY + says)
    assert not (folder / "out.toml").exists()
