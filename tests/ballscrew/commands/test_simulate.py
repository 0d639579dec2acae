"""`ballscrew simulate`: a recording, its truth and the machine's constants beside it."""

import json

import numpy as np
import pytest

from tests.conftest import ballscrew as run, json_of


def test_simulate_writes_a_recording_and_its_truth(tmp_path):
    status, out, _ = run("simulate", "FS-20", "-o", tmp_path / "new" / "a.log", "--seconds", 120, "--json")
    told = json.loads(out)
    assert status == 0
    assert told["seconds"] == pytest.approx(120, abs=1.1)
    assert told["path"] == str(tmp_path / "new" / "a.log")
    truth = np.genfromtxt(tmp_path / "new" / "a.truth.csv", delimiter=",", names=True)
    assert truth.dtype.names[:3] == ("time_s", "elongation_um", "T01")
    assert truth["elongation_um"].max() == pytest.approx(told["max_elongation_um"], abs=1e-3)
    assert told["max_elongation_um"] > 5


def test_another_machine_leaves_its_constants_beside_the_recording(tmp_path):
    drag = {}
    for number in (0, 7):
        words = ["-o", tmp_path / f"{number}.log", "--seconds", 2, "--machine", number]
        assert json_of("simulate", "FS-20", *words)["machine"] == number
        drag[number] = json.loads((tmp_path / f"{number}.machine.json").read_text())["constants"]["nut"]["drag_torque"]
    assert drag[0] == 0.68
    assert drag[7] != 0.68


def test_the_same_seed_is_the_same_recording(tmp_path):
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        assert run("simulate", "ES-20", "-o", tmp_path / f"{name}.log", "--seconds", 40, "--seed", seed)[0] == 0
    a, b, c = ((tmp_path / f"{name}.log").read_bytes() for name in "abc")
    assert a == b
    assert a != c
