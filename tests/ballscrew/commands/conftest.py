"""A working directory with effects of one's own, and commands that end well, or with one line."""

import shutil
from pathlib import Path

import pytest

from tests.conftest import PAPER, ended

OWN = '''
from estimator.effect import Effect, Param
from estimator.effects.local import LocalHeat, spot
from estimator.terms import SCREW, Heat


class CoolantJet(Effect):
    """A jet of coolant cools one place while the pump [2] runs.

    q = -P around x = 350 mm
    """

    trace = "One place too cold."
    power = Param(5.0, "W", lo=-50.0, hi=50.0, null=0.0, source="a guess")

    def terms(self, p, u, rig):
        yield Heat(SCREW, -p.power, over=spot(rig, 350.0, 30.0))
'''


SECOND = '''

class Rubbing(Effect):
    """Something rubs.

    q = |P|
    """

    power = Param(5.0, "W", lo=-50.0, hi=50.0, null=0.0, source="a guess")

    def terms(self, p, u, rig):
        yield Heat(SCREW, abs(p.power), over=spot(rig, 500.0, 30.0))
'''


@pytest.fixture
def own_effects(tmp_path, monkeypatch) -> Path:
    """A working directory with a model and an effect file, far from any rig.toml."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "effects.py").write_text(OWN)
    shutil.copy(PAPER / "base.toml", tmp_path / "model.toml")
    return tmp_path


def done(*words: object) -> str:
    out, _ = ended(0, *words)
    return out


def refused(*words: object) -> str:
    """The one line with which a command refuses."""
    _, err = ended(2, *words)
    (line,) = [line for line in err.splitlines() if not line.startswith("note: ")]
    assert line.startswith("error: ")
    return line.removeprefix("error: ")
