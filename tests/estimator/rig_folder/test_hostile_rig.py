"""Whatever is written into rig.toml: a rig that works, or one line that names the file and the place."""

import copy
import dataclasses
import json
import math
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import pytest
from hypothesis import given, strategies as st

from estimator import rig as records
from estimator.battery import exercise
from estimator.errors import SetupError
from estimator.rig import Rig
from estimator.rig_folder.bounds import BOUNDS
from estimator.rig_folder.contradictions import contradictions
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from tests.conftest import PAPER, ROD, ROOT
from tests.processes import ended

MODELS = {folder: load_model(folder / "model.toml") for folder in (PAPER, ROD)}
EVERY = {  # what the files of the rigs leave out
    PAPER: {
        "screw": {"cells": 270, "reference_rpm": 1667.0, "knots_mm": []},
        "zero_C": 20.0,
        "zero_sd_K": 0.1,
    },
    ROD: {
        "screw": {"bore_mm": 1.0, "lead_mm": 5.0, "span_from_mm": 10.0, "span_to_mm": 390.0},
        "subset_7": ["TC1", "TC2"],
        "supports": {"left": {"at_mm": 10.0, "width_mm": 20.0}},
    },
}
WRONG = st.one_of(
    st.sampled_from([math.nan, math.inf, -math.inf, 0, 0.0, -1, 1, 12, 1e300, -1e300, 1e-300, 10**9, 10**400, True]),
    st.sampled_from(["", " ", "x", "K", "furlong", "a\nb", "\0", "x" * 1000, "screw", [], [[]], {}, {"a": 1}]),
    st.floats(),
    st.integers(),
    st.text(max_size=20),
)  # fmt: skip


def good(folder: Path) -> dict[str, Any]:
    """A rig file with nearly every key that there is."""
    table = tomllib.loads((folder / "rig.toml").read_text())
    for key, value in copy.deepcopy(EVERY[folder]).items():
        table[key] = {**table.get(key, {}), **value} if isinstance(value, dict) else value
    return table


def places(table: dict[str, Any], at: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    for key, value in table.items():
        yield (*at, key)
        if isinstance(value, dict):
            yield from places(value, (*at, key))


def toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    return json.dumps(value) if isinstance(value, (str, bool)) else repr(value)


def written(folder: Path, table: dict[str, Any]) -> Path:
    text = "".join(f"{json.dumps(key)} = {toml(value)}\n" for key, value in table.items())
    (folder / "rig.toml").write_bytes(text.encode("utf-8", "backslashreplace"))
    return folder


def tried(job: Callable[[], Any]) -> tuple[Any, str]:
    """What a job returns, and the error of ours that it ends with; anything else is a bug."""
    try:
        return job(), ""
    except SetupError as error:
        return None, str(error)


def works(rig: Rig, folder: Path) -> None:
    """The model of the rig runs on it, and what it reads is of this world; else it says what does not fit."""
    read, said = tried(lambda: exercise.open_loop(MODELS[folder], rig, exercise.run(rig)))
    assert "\n" not in said
    assert said or (np.isfinite(read).any() and not np.isinf(read).any())


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("hostile")


@pytest.mark.parametrize("rig", [PAPER, ROD], ids=["paper", "rod"])
@given(data=st.data())
def test_any_value_anywhere_is_a_rig_or_one_line(folder, rig, data):
    table = good(rig)
    at = data.draw(st.sampled_from(list(places(table))))
    inside = table
    for key in at[:-1]:
        inside = inside[key]
    old = inside[at[-1]]
    wrong = [WRONG, st.just(None)]
    if isinstance(old, (int, float)):
        wrong.append(st.sampled_from([-old, 1e3 * old, 1e-3 * old, 1e6 * old, str(old), [old]]))
    inside[at[-1]] = data.draw(st.one_of(*wrong))
    if inside[at[-1]] is None:
        del inside[at[-1]]
    found, said = tried(lambda: load_rig(written(folder, table)))
    if found:
        works(found, rig)
        return
    assert said.startswith(f"{folder / 'rig.toml'}")
    assert "\n" not in said
    assert len(said) < 1000


@pytest.mark.parametrize("record", [records.Screw, records.Nut, records.Support, records.Signal, records.Channel])
def test_every_number_has_bounds_that_hold_its_default(record):
    hints = get_type_hints(record)
    numbers = {
        f.name: f.default for f in dataclasses.fields(record) if "float" in str(hints[f.name]) or hints[f.name] is int
    }
    assert set(BOUNDS[record]) == set(numbers)
    for key, default in numbers.items():
        if isinstance(default, (int, float)):
            BOUNDS[record][key].check(default, key)


@pytest.mark.parametrize(
    ("rig", "at", "value", "says"),
    [
        (PAPER, "screw.conductivity", -5, "screw.conductivity is -5, must be 0.05 ... 5000 W/(m K); steel has 46"),
        (PAPER, "screw.expansion", 12, "screw.expansion is 12, must be -2e-06 ... 0.0005 1/K; steel has 12e-6"),
        (PAPER, "screw.expansion", 0.0, "screw.expansion is 0: nothing would grow; steel has 12e-6 1/K"),
        (PAPER, "screw.density", 0, "screw.density is 0, must be 100 ... 25000 kg/m3; steel has 7850"),
        (PAPER, "screw.heat_capacity", math.nan, "screw.heat_capacity is nan, must be 50 ... 10000 J/(kg K);"),
        (PAPER, "screw.cells", 10**9, "screw.cells is 1000000000, must be 2 ... 2000; 2 to 5 mm each are enough"),
        (PAPER, "screw.cells", True, "screw.cells: expected int, got True"),
        (PAPER, "screw.cells", 10, "screw: cells = 10 cannot tell 26 places of thermometers, bearings and "
         "knots_mm apart, 10.562 mm the closest; take more cells, or places"),
        (PAPER, "screw.knots_mm", [0, 0, 900], "screw: cells = 270 cannot tell 3 places of thermometers, bearings and "
         "knots_mm apart, 0 mm the closest"),
        (PAPER, "screw.knots_mm", [5.0], "screw: 1 places of states along it, must be 2 ... 200; choose"),
        (PAPER, "screw.span_from_mm", 990.0, "screw: span_from_mm must be below span_to_mm: 990 ... 980 mm"),
        (PAPER, "screw.bore_mm", 40.0, "screw: bore_mm must be below outer_mm: 40 and 40 mm"),
        (PAPER, "nut.direction", 0.5, "nut.direction is 0.5, must be 1 or -1: which way its centre moves"),
        (PAPER, "nut.centre_mm", 4e4, "nut: at no position from -100 to 800 mm is it on the screw: it covers "
         "39112.5 ... 40187.5 mm, the screw -50 ... 1030 mm; correct nut.centre_mm"),
        (PAPER, "channels.T03.unit", "F", "channels.T03.unit: 'F' is no unit of a thermometer; use degC; scale and "
         "offset convert"),
        (PAPER, "channels.displacement.unit", "mm", "channels.displacement.unit: 'mm' is no unit of a length; use um, "
         "or at_mm or node if it is a thermometer"),
        (PAPER, "inputs.ambient.unit", "degF", "inputs.ambient.unit: 'degF' is no unit of it; use degC"),
        (PAPER, "inputs.position.unit", "furlong", "inputs.position.unit: 'furlong' is no unit of it; use mm"),
        (PAPER, "inputs.ambient.hi", -300.0, "ambient: lo = -60 is not below hi = -300"),
        (PAPER, "channels.T03.signal", "Telemeter1.T02", "channels.T03: Telemeter1.T02 is read by channels.T02"),
        (PAPER, "channels.T03.signal", 5, "channels.T03.signal: expected str, got 5"),
        (PAPER, "channels.T03.node", "screw", "channels.T03 has both at_mm and node"),
        (PAPER, "inputs.T03", {}, "inputs.T03: a channel has that name already; rename one of them"),
        (PAPER, "inputs.start", {}, "inputs: 'start' cannot be a name"),
        (PAPER, "log.scan", [], "log.scan_state is of a scan, but there is no log.scan"),
        (PAPER, "log.closes", "", "log.closes: expected 1 to 200 characters in one line, got ''"),
        (PAPER, "subset_7", ["T02", "T02"], "subset_7: a thermometer is named twice"),
        (PAPER, "name", {}, "name: expected str, got {}"),
        (PAPER, "tick_s", 10**400, "tick_s is 1000"),
        (PAPER, "zero_C", 293.15, "zero_C is 293.15, must be -60 ... 200 degC; 20 is the reference temperature"),
        (PAPER, "zero_C", math.nan, "zero_C is nan, must be -60 ... 200 degC"),
        (PAPER, "zero_sd_K", -0.1, "zero_sd_K is -0.1, must be 0 ... 10 K"),
        (PAPER, "bed", {"input": "bsae"}, "bed.input: no input 'bsae'; did you mean 'base'?"),
        (PAPER, "bed", {"input": "speed"}, "bed.input: 'speed' is in rpm; name a thermometer"),
        (PAPER, "bed", {"input": "base", "expansion": 11}, "bed.expansion is 11, must be -2e-06 ... 0.0005 1/K"),
        (PAPER, "bed", {}, "bed: 'input' is missing"),
        (ROD, "bed", {"input": "ambient"}, "[bed] is what the error at the table is told against: it needs [nut] and"),
        (ROD, "zero_sd_K", 0.1, "zero_sd_K is how well zero_C is known, but there is no zero_C"),
        (ROD, "channels", {"gauge": {"unit": "um"}}, "channels: no thermometer among them"),
        (ROD, "channels.TC1.scale", 0, "channels.TC1.scale is 0: every reading would be the same"),
        (ROD, "supports.left.width_mm", 0.0, "supports.left.width_mm is 0.0, must be 0.1 ... 10000 mm"),
    ],
)  # fmt: skip
def test_nonsense_is_named_with_its_place_and_what_it_must_be(tmp_path, rig, at, value, says):
    table = good(rig)
    inside, keys = table, at.split(".")
    for key in keys[:-1]:
        inside = inside[key]
    inside[keys[-1]] = value
    with pytest.raises(SetupError) as caught:
        load_rig(written(tmp_path, table))
    assert str(caught.value).startswith(f"{tmp_path / 'rig.toml'}: {says}")


GOOD = (ROD / "rig.toml").read_bytes()


@pytest.mark.parametrize("content", [b"\xef\xbb\xbf" + GOOD, GOOD.replace(b"\n", b"\r\n")], ids=["BOM", "CRLF"])
def test_a_rig_file_saved_by_other_editors_is_the_same(tmp_path, content):
    (tmp_path / "rig.toml").write_bytes(content)
    assert dataclasses.replace(load_rig(tmp_path), folder=ROD) == load_rig(ROD)


@pytest.mark.parametrize(
    "content",
    [
        b"", b"\0", b"\xff\xfe" + GOOD, GOOD.decode().encode("utf-16"), GOOD[:300], GOOD + GOOD,
        b"x = " + b"[" * 100_000, b"#" * 2_000_000, b"a = " + b"9" * 10_000, b'"a\\nb" = 1', b"a" * 90_000 + b" = 1",
        b"name = 1979-05-27\nchannels = {}",
    ],
)  # fmt: skip
def test_what_is_no_rig_file_ends_in_one_line(tmp_path, content):
    (tmp_path / "rig.toml").write_bytes(content)
    with pytest.raises(SetupError) as caught:
        load_rig(tmp_path)
    assert str(caught.value).startswith(str(tmp_path / "rig.toml"))
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 1000


def test_a_folder_in_its_place_is_no_file(tmp_path):
    (tmp_path / "rig.toml").mkdir()
    with pytest.raises(SetupError, match=r"rig.toml: not a file"):
        load_rig(tmp_path)


def test_the_command_ends_with_2_and_one_line(tmp_path):
    table = good(ROD)
    table["screw"]["conductivity"] = -5
    done = ended("ballscrew", "review", ROD / "check.csv", "--rig", written(tmp_path, table), cwd=ROOT)
    assert done.returncode == 2
    assert done.stderr == (
        f"error: {tmp_path / 'rig.toml'}: screw.conductivity is -5, must be 0.05 ... 5000 W/(m K); steel has 46\n"
    )


def test_a_zero_needs_a_screw_that_grows():
    heaters = load_rig(ROOT / "examples" / "two_heaters")
    assert list(contradictions(dataclasses.replace(heaters, zero_C=20.0))) == [
        "zero_C is where the growth of the screw is zero, but there is no [screw]; leave it out"
    ]
