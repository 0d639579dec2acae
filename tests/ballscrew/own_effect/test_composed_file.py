"""A composed effect is put behind what a file of one's own has, or the file is refused before anything is searched."""

import ast
import shlex
from pathlib import Path
from types import SimpleNamespace

import pytest

from ballscrew.commands.suggest import _check
from ballscrew.own_effect.composed_file import taken_in, write_composed
from ballscrew.own_effect.named import Named
from ballscrew.terminal import Terminal
from ballscrew.workspace import Workspace
from estimator.errors import SetupError
from estimator.inputs.follower import SPEED
from estimator.model import Value
from estimator.rig_folder.model_toml import load_model, own_effects
from estimator.rig_folder.rig_folder import load_rig
from estimator.unknown.effect_text import effect_text
from estimator.unknown.stand_ins import Unknown
from estimator.unknown.written import effect_of, name_of, wanted_of
from tests.conftest import PAPER


def made(taken=()) -> SimpleNamespace:
    unknown = Unknown(SPEED, at_mm=300.0)
    text = effect_text(wanted_of(unknown, name_of(unknown, taken), {"power": Value(3.0, 0.2)}), load_rig(PAPER))
    return SimpleNamespace(text=text, effect=effect_of(text))


BEFORE = [
    "from estimator.terms import *\n",
    "from estimator.effect import Effect, Param; from estimator.terms import SCREW\n",
    "NAME = 'a\u2028b\x0cc'\n",
    "HeatNear300 = 3\n",
    "import numpy as np\n\nclass heat_near300:\n    pass\n",
    "\ufeffWIDTH = 3.0\n",
]


@pytest.mark.parametrize("before", BEFORE)
def test_what_a_file_has_stays_as_it_is(before, tmp_path):
    path = tmp_path / "effects.py"
    path.write_text(before, encoding="utf-8")
    one = made(taken_in(path))
    (named,) = write_composed([one], path)
    assert named.effect.__name__ in own_effects(path)
    kept = ast.dump(ast.parse(before.lstrip("\ufeff")).body[-1])
    assert kept in [ast.dump(node) for node in ast.parse(path.read_text(encoding="utf-8-sig")).body]


def test_the_check_that_comes_next_is_on_the_rig_and_the_model_that_were_asked(tmp_path):
    one, rig = Named(made().effect, tmp_path / "my effects.py"), load_rig(PAPER)
    model = load_model(PAPER / "base.toml")
    said = _check(one, Workspace(Terminal(), rig, model))
    words = ["--check", "--rig", str(PAPER), "--model", str(PAPER / "base.toml")]
    assert shlex.split(said) == ["ballscrew", "effects", f"{tmp_path}/my effects.py:HeatNear300", *words]
    beside = Named(made().effect, PAPER / "effects.py")
    assert _check(beside, Workspace(Terminal(), rig, load_model(PAPER / "model.toml"))).endswith("HeatNear300 --check")


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("effects.txt", b"", "effects.txt: effects are Python: take a file whose name ends with .py"),
        ("effects.py", b"def Heat():\n    pass\n", "effects.py: 'Heat' is something else there"),
        ("effects.py", b"x = '\xe4'\n", "effects.py: byte 5 is not UTF-8"),
        ("effects.py", b"x = 1\x00\n", "effects.py: "),
        ("effects.py", b"def (\n", "effects.py: line 1 is not Python"),
    ],
)
def test_a_file_that_cannot_take_it_is_refused(name, content, says, tmp_path):
    path: Path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(SetupError) as refused:
        taken_in(path)
    assert says in str(refused.value)
