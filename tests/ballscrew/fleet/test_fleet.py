"""A plant: a row a rig, the same with any number of workers, and with one that is killed."""

import json
import shutil
from functools import partial
from pathlib import Path

import pytest

from ballscrew.fleet.workers import LOST, shared
from ballscrew.workers.by_value import MOST_LOST
from tests.ballscrew.fleet.killing import killed
from tests.conftest import EXAMPLES, ballscrew, ended
from tests.viz_read import fixed


@pytest.fixture(scope="module")
def plant(tmp_path_factory) -> Path:
    """A rod that is as its model says, two heaters that are not, no model, no recording."""
    folder = tmp_path_factory.mktemp("plant")
    for name, files in {
        "rod": ("heated_rod", "check.csv"), "heaters": ("two_heaters", "both.csv"), "new": ("two_heaters", ""),
        "empty": ("heated_rod", ""),
    }.items():  # fmt: skip
        (folder / name).mkdir()
        for file in ("rig.toml", "model.toml", "effects.py", files[1]):
            if file and not (name == "new" and file == "model.toml"):
                shutil.copy(EXAMPLES / files[0] / file, folder / name)
    (folder / "empty" / "x.csv").write_text("hello\n")
    return folder


@pytest.fixture(scope="module")
def alone(plant) -> tuple[str, str]:
    """What one process prints of it, and its JSON."""
    told, said = ended(1, "fleet", plant, "--workers", 1, "--json", "--save", plant / "plant.rrd")
    return said, told


def test_each_rig_is_a_row_and_one_that_fails_says_why(alone):
    out, _ = alone
    table = out[out.index("band, um") :].splitlines()[1:5]  # what compiles first is said before it
    rows = {Path(line.split()[0]).name: line.split()[1:] for line in table}
    assert list(rows) == ["empty", "heaters", "new", "rod"]
    assert rows["rod"][-1] == "adequate"
    assert rows["heaters"][-1] == "fails"
    assert rows["new"] == rows["empty"] == ["failed"]
    assert "no model.toml beside rig.toml" in out
    assert "x.csv: no column of any channel" in out


def test_the_views_have_a_row_each_and_say_what_the_table_says(plant, alone):
    assert list(fixed(plant / "plant.rrd", "/plant/2/0/channels", "Points2D:labels")) == [
        "empty: failed", "new: failed", "heaters: model fails", "rod"
    ]  # fmt: skip
    assert alone[0].splitlines()[-1].startswith(f"views: {plant / 'plant.rrd'}")
    (summary,) = fixed(plant / "plant.rrd", "/summary", "TextDocument:text")
    assert "no model.toml beside rig.toml" in summary


def test_no_views_are_written_where_no_rig_could_be_used(plant, tmp_path):
    _, err = ended(1, "fleet", plant / "new", "--save", tmp_path / "plant.rrd")
    assert "not written: no rig has a recording that could be used" in err


def test_the_same_numbers_whoever_does_the_work(plant, alone):
    _, told = alone
    assert ballscrew("fleet", plant, "--workers", 2, "--json")[1] == told
    rigs = {Path(rig["folder"]).name: rig for rig in json.loads(told)["rigs"]}
    assert rigs["rod"]["adequate"] is True
    assert rigs["rod"]["recordings"] == 1
    assert rigs["rod"]["drifts"] is None
    assert rigs["heaters"]["adequate"] is False
    assert rigs["new"]["error"]
    assert set(rigs["rod"]) == {
        "folder", "recordings", "failed", "filter", "nis", "adequate", "verdict", "where", "drifts", "error",
    }  # fmt: skip


def test_a_folder_of_no_rig_names_the_way_to_one(tmp_path):
    _, err = ended(2, "fleet", tmp_path)
    assert "no rig.toml in it, nor in a folder of it; `ballscrew init LOG -o FOLDER` makes one" in err


@pytest.mark.parametrize("times", [1, MOST_LOST])
def test_a_lost_worker_costs_only_what_it_was_at(tmp_path, times):
    folders = [Path(name) for name in ("a", "b", "bad", "c", "d")]
    found = {one.folder: one for one in shared(partial(killed, tmp_path, times), folders, 2)}
    well = {name for name, one in found.items() if not one.error}
    assert well == {"a", "b", "c", "d"} | ({"bad"} if times == 1 else set())
    if times == MOST_LOST:
        assert found["bad"].error == LOST
