"""The page about effects: its catalogue, checks, followers and terms are those of the code, and its example passes."""

import dataclasses
import re
from pathlib import Path
from typing import get_args

import pytest

from estimator import terms
from estimator.battery.battery import CHECKS, battery
from estimator.effect import Param
from estimator.effects import HEAT, MOUNTING, READING, STRUCTURE
from estimator.inputs.follower import NAMES
from estimator.rig_folder.model_toml import own_effect

PAGE = Path(__file__).parents[3] / "docs" / "effects.md"


def section(title: str) -> str:
    """What stands below a title, down to the next one."""
    text = PAGE.read_text()
    assert text.count(f"\n{title}\n") == 1, title
    return re.split(r"^#+ ", text.split(f"\n{title}\n")[1], maxsplit=1, flags=re.MULTILINE)[0]


def rows(title: str) -> list[list[str]]:
    """Cells of the tables of a section, without heads."""
    tables = re.findall(r"^\|.*\n\| ---.*\n((?:\|.*\n)+)", section(title), re.MULTILINE)
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for table in tables for line in table.splitlines()]


@pytest.mark.parametrize(
    ("title", "effects"), [("Structure", STRUCTURE), ("Mounting", MOUNTING), ("Heat", HEAT), ("Reading", READING)]
)
def test_the_catalogue_is_on_the_page(title, effects):
    assert rows(f"### {title}") == [[f"`{effect.name}`", effect.sentence(), effect.trace] for effect in effects]


def test_every_term_is_on_the_page_with_its_fields_in_order():
    found = {row[0].strip("`") for row in rows("### The vocabulary")}
    for term in (*get_args(terms.Term), terms.Spot):
        assert f"{term.__name__}({', '.join(f.name for f in dataclasses.fields(term))})" in found


def test_every_key_of_a_parameter_is_on_the_page():
    keys = [key.strip("`") for row in rows("### A parameter") for key in row[0].split(", ")]
    assert keys == [f.name for f in dataclasses.fields(Param)]


def test_every_check_and_follower_is_on_the_page():
    assert [row[0] for row in rows("### What must hold")] == list(CHECKS)
    assert [row[0].strip("`") for row in rows("### A new effect as a file")] == [*NAMES, "any input"]


def test_the_example_of_the_page_passes(tmp_path, full, rig):
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (tmp_path / "effects.py").write_text(code)
    found = battery(own_effect("effects.py:CoolantJet", tmp_path), full, rig)
    assert [finding.detail for finding in found] == [""] * len(CHECKS)
