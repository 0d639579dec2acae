"""The page about rig folders: every key is there with its default, and its blocks are the example files."""

import dataclasses
import re
import tomllib

import pytest

from estimator import model, rig, rig_log, screw
from estimator.rig_folder.rig_folder import load_rig
from tests.conftest import ROOT

PAGE = ROOT / "docs" / "rig-folder.md"
BLOCK = re.compile(r"`(examples/[\w/.]+)`[^\n]*\n\n```(\w+)\n(.*?)```", re.DOTALL)
ROW = re.compile(r"^\| `(\w+)` \|([^|]*)\|([^|]*)\|([^|]*)\|$", re.MULTILINE)

SECTIONS = {
    "### Top of the file": (rig.Rig, {"folder"}),
    "### `[screw]`": (screw.Screw, set()),
    "### `[nut]`": (screw.Nut, set()),
    "### `[bed]`": (screw.Bed, set()),
    "### `[supports]`": (screw.Support, set()),
    "### `[channels]`": (rig.Channel, {f.name for f in dataclasses.fields(rig.Signal)}),
    "### A signal": (rig.Signal, set()),
    "### `[log]`": (rig_log.Log, set()),
    "### `csv`": (rig_log.Csv, set()),
    "### A parameter": (model.Value, set()),
}


def section(title: str) -> str:
    text = PAGE.read_text()
    assert text.count(f"\n{title}\n") == 1, title
    rest = text.split(f"\n{title}\n")[1]
    return re.split(r"^#+ ", rest, maxsplit=1, flags=re.MULTILINE)[0]


@pytest.mark.parametrize("title", SECTIONS)
def test_every_key_is_on_the_page_with_its_default(title):
    record, not_there = SECTIONS[title]
    rows = {key: default.strip() for key, _, default, _ in ROW.findall(section(title))}
    wanted = {f.name: f for f in dataclasses.fields(record) if f.name not in not_there}
    assert set(rows) == set(wanted)
    for key, field in wanted.items():
        if title == "### Top of the file" or record is model.Value:
            continue  # their defaults are the reader's, not the record's
        if field.default is dataclasses.MISSING:
            assert rows[key] == "required", key
        elif field.default in (None, (), rig_log.Csv()):
            assert rows[key].startswith("none") or rows[key] == "[]", key
        else:
            assert tomllib.loads(f"x = {rows[key]}")["x"] == field.default, key


def test_the_keys_of_a_model_file_are_on_the_page():
    text = PAGE.read_text().split("## model.toml")[1]
    for key in ("use", "about", "rig", "fitted_on", "value", "sd", "fixed"):
        assert f"`{key}`" in text or f"`[{key}]`" in text


def test_every_input_that_an_effect_of_the_catalogue_asks_for_is_on_the_page():
    text = section("### `[inputs]`")
    paper = load_rig(ROOT / "recordings")
    for name in paper.inputs:
        assert f"`{name}`" in text


def test_the_blocks_of_the_page_are_the_files():
    blocks = {path: (kind, body) for path, kind, body in BLOCK.findall(PAGE.read_text())}
    assert set(blocks) == {
        "examples/seven_channels/rig.toml", "examples/seven_channels/model.toml",
        "examples/heated_rod/rig.toml", "examples/heated_rod/model.toml", "examples/heated_rod/effects.py",
    }  # fmt: skip
    for path, (kind, body) in blocks.items():
        if kind == "toml":
            assert tomllib.loads(body) == tomllib.loads((ROOT / path).read_text())
        else:
            assert body == (ROOT / path).read_text()


def test_examples_stay_small():
    files = [path for path in (ROOT / "examples").rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    assert sum(path.stat().st_size for path in files) < 300_000
