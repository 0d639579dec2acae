"""`ballscrew new-effect`: an effect of one's own that passes as it is written."""

import subprocess
import sys
from pathlib import Path

import pytest

from estimator.inputs.follower import NAMES
from estimator.rig_folder.model_toml import load_model
from tests.ballscrew.commands.conftest import OWN, done, refused
from tests.conftest import json_of

READINGS = [None, "all", "T04", "displacement"]


def test_every_follower_and_reading_makes_an_effect_that_passes_as_written(own_effects):
    """Each follower everywhere, at a place, or with one of the readings, in turn."""
    (own_effects / "effects.py").unlink()
    rig_inputs = [*NAMES, "board", "ambient", "position"]
    for i, follows in enumerate(rig_inputs):
        reading = READINGS[i % 3 + 1] if i % 2 and not follows.startswith("temperature_") else None
        words = ["--reading", reading] if reading else ["--at", "350mm"] if i % 4 else []
        assert "effects.py: Effect" in done("new-effect", f"effect {chr(97 + i)}", "--follows", follows, *words)
    told = json_of("effects", "effects.py", "--check")
    assert len(told) == len(rig_inputs)
    assert {check["detail"] for one in told.values() for check in one["checks"]} == {""}
    assert all(one["trace"].endswith(".") for one in told.values())
    ruff = [
        Path(sys.executable).with_name("ruff"),
        "check",
        "--select",
        "E,F,B,UP",
        "--line-length",
        "120",
        "effects.py",
    ]
    assert subprocess.run(ruff, check=False).returncode == 0
    formatted = [ruff[0], "format", "--check", "--line-length", "120", "effects.py"]
    assert subprocess.run(formatted, check=False).returncode == 0


def test_what_is_printed_next_works(own_effects):
    (own_effects / "effects.py").unlink()
    out = done("new-effect", "oil-bath", "--at", "350 mm", "--follows", "early_stop")
    commands = [line.partition("ballscrew ")[2].split() for line in out.splitlines() if "ballscrew " in line]
    commands = [words for words in commands if words[0] in ("effects", "add")]
    assert commands == [
        ["effects", "effects.py:OilBath", "--check"],
        ["add", "effects.py:OilBath", "model.toml", "-o", "better.toml"],
    ]
    for words in commands:
        done(*words)
    model = load_model(own_effects / "better.toml")
    assert (model["oil_bath.at"], model.param("oil_bath.power").null) == (350.0, 0.0)


def test_a_new_effect_is_put_behind_what_is_there_without_running_it(own_effects):
    text = OWN + "\n\nassert not __name__, 'ran'  # the file's own last line\n"
    (own_effects / "effects.py").write_text(text)
    done("new-effect", "hot_rod", "--reading", "T04", "--follows", "temperature")
    new = (own_effects / "effects.py").read_text()
    head, _, rest = new.partition("\nclass CoolantJet")
    assert "from estimator.terms import SCREW, START, Heat, Read, Spot\n" in head
    assert rest.startswith(text.partition("\nclass CoolantJet")[2].rstrip())
    assert refused("new-effect", "hot_rod") == (
        "effects.py: 'HotRod' is there already; choose another name, or another file with -o"
    )
    assert (own_effects / "effects.py").read_text() == new


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ("4711", "'4711' cannot be an effect's name; take words of letters, such as coolant_jet"),
        ("heat", "'heat' cannot be an effect's name; take words of letters, such as coolant_jet"),
        ("churning", "the catalogue has an effect 'churning' already; choose another name"),
        ("jet --at here", "--at here: write a place in mm, such as 350mm, or one of: under-nut"),
        ("jet --at 2000mm", "--at 2000mm: outside the screw, -50 ... 1030 mm"),
        ("jet --at 35mm --reading T04", "--at is where heat goes, --reading shifts a reading: leave one"),
        ("jet --follows bord", "--follows bord: neither known nor an input of paper's ball screw; did you mean"),
        ("jet --reading displacment", "--reading displacment: paper's ball screw has no such channel; did you mean"),
        ("jet -o torn.py", "torn.py: line 1 is not Python: '(' was never closed; correct it first"),
        ("jet -o none/x.py", "none/x.py: there is no folder none"),
    ],
)
def test_what_cannot_be_written_is_said_in_a_line(words, text, own_effects):
    (own_effects / "torn.py").write_text("print(\n")
    before = (own_effects / "effects.py").read_text()
    assert refused("new-effect", *words.split()).startswith(text)
    assert (own_effects / "effects.py").read_text() == before


def test_a_word_of_the_vocabulary_that_means_something_else_in_the_file(own_effects):
    (own_effects / "effects.py").write_text("def spot(rig, at, width):\n    return 1.0\n")
    assert refused("new-effect", "jet", "--at", "350mm").startswith("effects.py: 'spot' is there already; ")
    done("new-effect", "jet")


@pytest.mark.parametrize(
    ("head", "line"),
    [
        ("", "from estimator.effect import Effect, Param"),
        ('"""Mine."""\n', "from estimator.effect import Effect, Param"),
        ("import numpy as np\n\nX = 1\n", "from estimator.effect import Effect, Param"),
        ("from estimator.effect import (\n    Effect,\n)\n", "from estimator.effect import Param"),
        ("from estimator.terms import Heat  # mine\n", "from estimator.terms import SCREW"),
    ],
)
def test_imports_go_where_imports_are(head, line, own_effects):
    (own_effects / "effects.py").write_text(head)
    done("new-effect", "jet", "--follows", "early_stop")
    assert line in (own_effects / "effects.py").read_text().splitlines()
    done("effects", "effects.py", "--check")
