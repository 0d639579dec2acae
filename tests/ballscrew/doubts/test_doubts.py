"""`ballscrew check`: none on what ships, and for each thing that is wrong a line with its place and its fix."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import PAPER, ROD, ROOT, TWO, ballscrew, ended, json_of


def doubts(*words: object) -> list[dict]:
    """What a check that must succeed doubts."""
    return json_of("check", *words)


def the_one(*words: object) -> tuple[str, str, str]:
    """Place, doubt and fix of the only doubt."""
    (one,) = doubts(*words)
    return one["place"], one["doubt"], one["fix"]


def put(folder: Path, *changes: tuple[str, str], name: str = "rig.toml") -> Path:
    """Change a file of a rig folder, each by a regular expression that is there."""
    text = (folder / name).read_text()
    for old, new in changes:
        assert re.search(old, text), old
        text = re.sub(old, new, text)
    (folder / name).write_text(text)
    return folder


@pytest.fixture
def screw(short_log, tmp_path) -> Path:
    """The paper's rig with two minutes of FS-20."""
    folder = tmp_path / "screw"
    folder.mkdir()
    for path in (PAPER / "rig.toml", PAPER / "model.toml", ROOT / "drivers" / "rig.dbc", short_log):
        shutil.copy(path, folder)
    return folder


@pytest.fixture
def rod(tmp_path) -> Path:
    """The heated rod with one recording."""
    folder = tmp_path / "rod"
    shutil.copytree(ROD, folder, ignore=shutil.ignore_patterns("__pycache__", "p*.csv", "s*.csv"))
    return folder


def frames(log: Path, change: Callable[[float, str, str, str], tuple[float, str, str, str] | None]) -> None:
    """Change or leave out frames of a candump log: s, bus, id, data."""
    kept = []
    for line in log.read_text().splitlines():
        stamp, bus, frame = line.split()
        name, data = frame.split("#")
        if found := change(float(stamp.strip("()")), bus, name, data):
            kept.append("({:.6f}) {} {}#{}\n".format(*found))
    log.write_text("".join(kept))


def cells(path: Path, name: str, change: Callable[[float], float]) -> None:
    """Change a column of a CSV."""
    head, *rows = [line.split(",") for line in path.read_text().splitlines()]
    place = head.index(name)
    for row in rows:
        row[place] = f"{change(float(row[place])):.2f}"
    path.write_text("\n".join(",".join(row) for row in [head, *rows]) + "\n")


# --- what ships


@pytest.mark.parametrize("folder", [ROD, TWO, ROOT / "examples" / "seven_channels"], ids=lambda path: path.name)
def test_what_ships_is_in_no_doubt(folder):
    assert doubts(folder) == []


def test_neither_are_the_paper_s_recordings():
    """FS-20: with two signals exchanged, below, no other doubt."""
    assert doubts(PAPER, PAPER / "CS-10.blf", PAPER / "ES-20.blf") == []


def test_neither_is_a_drive_and_its_stop(screw, fs20_log):
    assert doubts(screw, fs20_log) == []
    status, out, _ = ballscrew("check", screw)
    assert (status, "screw: no doubt" in out) == (0, True)


# --- signals


def test_a_message_that_never_comes_and_what_the_model_lacks_by_it(screw):
    frames(screw / "FS-20.log", lambda s, bus, name, data: None if name == "240" else (s, bus, name, data))
    found = {one["place"]: one["doubt"] for one in doubts(screw)}
    assert found["rig.toml"] == "message Environment1 never came: no ambient, base, anchor_bracket, free_bracket"
    assert found["rig.toml: inputs.ambient"].startswith("never read, and still_air of the model takes it")
    assert "housing_shells" in found["rig.toml: inputs.base"]


def test_a_column_that_is_called_otherwise(rod):
    head, rest = (rod / "check.csv").read_text().split("\n", 1)
    (rod / "check.csv").write_text(head.replace("TC5", "TCfive") + "\n" + rest)
    found = {one["place"]: (one["doubt"], one["fix"]) for one in doubts(rod)}
    assert found["rig.toml: channels.TC5"][0] == "no column 'TC5'"
    assert "TCfive" in found["rig.toml"][0]


def test_a_column_without_a_number_is_there_and_no_other_is_proposed_for_it(rod):
    cells(rod / "check.csv", "TC3", lambda value: np.nan)
    assert the_one(rod) == (
        "rig.toml: channels.TC3", "column 'TC3' holds no number", "look at that sensor and its logger",
    )  # fmt: skip


def test_temperatures_that_nobody_named(screw):
    put(screw, ("T03 = .*\n", ""), ("free_bracket = .*\n", ""))
    place, doubt, fix = the_one(screw)
    assert doubt == "it names none of these temperatures: Telemeter1.T03, Environment1.EnvBracketFree"
    assert (place, "[channels] or [inputs]" in fix) == ("rig.toml", True)


def test_a_dbc_in_other_units(screw):
    put(screw, (r'(SG_ DspHold\w+ : \d+\|24.*)"um"', r'\1"mm"'), (r'(SG_ T05 .*)"degC"', r'\1"K"'), name="rig.dbc")
    found = {one["place"]: (one["doubt"], one["fix"]) for one in doubts(screw)}
    assert found["rig.toml: channels.displacement"] == (
        "DisplacementHold.DspHoldA1B1 is in mm, it says um", "scale = 500",
    )  # fmt: skip
    assert found["rig.toml: channels.T05"] == ("Telemeter2.T05 is in K, it says degC", 'unit = "K"')


def test_readings_in_kelvin_and_out_of_range(rod):
    cells(rod / "check.csv", "TC2", lambda value: value + 273.15)
    put(rod, (r"TC7 = \{ at_mm = 330.0", "TC7 = { at_mm = 330.0, lo = 18.0"))
    found = {one["place"]: one for one in doubts(rod)}
    kelvin, range_ = found["rig.toml: channels.TC2"], found["rig.toml: channels.TC7"]
    assert kelvin["fix"] == 'in K? Then unit = "K"'
    assert kelvin["doubt"].startswith("781 of 781 readings are outside -60 ... 200 degC: TC2 has 295")
    assert range_["fix"] == "correct lo and hi, or scale and offset"
    assert doubts(put(rod, (r"TC2 = \{", 'TC2 = { unit = "K",'), ("lo = 18.0", "lo = 0.0"))) == []


def test_a_thermometer_that_never_changes(rod):
    cells(rod / "check.csv", "TC4", lambda value: 22.0)
    assert ("rig.toml: channels.TC4", "always reads 22 degC", "look at that sensor and its signal") in [
        (one["place"], one["doubt"], one["fix"]) for one in doubts(rod)
    ]


def test_a_tick_that_is_none_of_the_scan(rod):
    assert the_one(put(rod, ("tick_s = 5.0", "tick_s = 1.0"))) == (
        "rig.toml: tick_s", "thermometers come each 5 s, tick_s is 1", "tick_s = 5",
    )  # fmt: skip


def test_two_clocks_are_told(screw):
    def ahead(s: float, bus: str, name: str, data: str) -> tuple[float, str, str, str]:
        return (s + 0.8, "can1", name, data) if name in ("220", "221", "230") else (s, bus, name, data)

    frames(screw / "FS-20.log", ahead)
    place, doubt, _ = the_one(screw)
    assert place == "FS-20.log"
    assert "clock" in doubt


# --- the order of the thermometers


@pytest.mark.parametrize(("one", "other"), [("TC3", "TC6"), ("TC7", "TC8"), ("TC1", "TC2")])
def test_two_places_that_are_exchanged(rod, one, other):
    at = dict(re.findall(r"(TC\d) = \{ at_mm = ([\d.]+)", (rod / "rig.toml").read_text()))
    put(rod, *((rf"{a} = {{ at_mm = [\d.]+", f"{a} = {{ at_mm = {at[b]}") for a, b in ((one, other), (other, one))))
    place, doubt, _ = the_one(rod)
    assert place == "rig.toml: channels"
    assert {one, other} <= {*re.findall(r"\w+", doubt)}


def test_two_signals_of_the_screw_that_are_exchanged(screw):
    """Seen an hour after the stop only: while it is driven the bearings' peaks look as odd."""
    put(screw, (r"Telemeter2\.T05\"", '@"'), (r"Telemeter3\.T12\"", 'Telemeter2.T05"'), ("@", "Telemeter3.T12"))
    assert doubts(screw) == []
    place, doubt, _ = the_one(screw, PAPER / "FS-20.blf")
    assert (place, doubt.split(":")[0]) == ("rig.toml: channels", "T05 and T12")


# --- drive and growth


@pytest.mark.parametrize(
    ("old", "new", "place", "doubt"),
    [
        ("lead_mm = 12.0", "lead_mm = 20.0", "inputs.speed", "12 mm a turn by speed and position, screw.lead_mm is 20"),
        ("centre_mm = 673.5", "centre_mm = 300.0", "nut", "its centre goes to -99 ... 300 mm, the screw is -50"),
        (r"scale = 0.5, (.*DspHoldSeq)", r"scale = -0.5, \1", "channels.displacement", "falls by 1"),
        (r"scale = 0.5, (.*DspHoldSeq)", r"scale = 4.0, \1", "channels.displacement", "grows by "),
    ],
)
def test_speed_nut_and_growth(screw, old, new, place, doubt):
    put(screw, (old, new))
    where, what, _ = the_one(screw)
    assert where == f"rig.toml: {place}"
    assert what.startswith(doubt)


def table_run(tmp_path: Path, rpm: Callable[[np.ndarray], np.ndarray], metres: bool = False) -> Path:
    """A rig whose table goes to and fro by 100 mm, between two rests."""
    s = np.arange(400) * 1.0
    place = 100 + 100 * np.abs((np.clip(s, 100, 300) / 50) % 2 - 1)
    rows = np.column_stack([s, 20 + s / 100, 20 + s / 80, rpm(s), place / (1000 if metres else 1)])
    np.savetxt(tmp_path / "run.csv", rows, "%.6g", ",", header="time_s,T1,T2,speed,position", comments="")
    (tmp_path / "rig.toml").write_text(
        'name = "x"\n[screw]\nfrom_mm = 0\nto_mm = 500\nouter_mm = 30\n[channels]\nT1 = {at_mm = 10}\n'
        'T2 = {at_mm = 400}\n[inputs]\nspeed = {unit = "rpm", hi = 5000}\nposition = {unit = "mm", hi = 1000}\n'
    )
    (tmp_path / "model.toml").write_text("[conduction]\n[thermometers]\n")
    return tmp_path


def test_a_folder_without_a_model(tmp_path):
    folder = table_run(tmp_path, lambda s: 10.0 * ((s > 100) & (s < 300)))
    assert doubts(folder) == []
    (folder / "model.toml").unlink()
    assert the_one(folder)[:2] == ("model.toml", "is not there")


def test_a_speed_of_something_else(tmp_path):
    place, doubt, _ = the_one(table_run(tmp_path, lambda s: 1000 + 50 * np.sin(s / 3)))
    assert (place, doubt) == ("rig.toml: inputs.speed", "it is not how fast the position changes")


def test_a_speed_that_is_always_0(tmp_path):
    place, doubt, _ = the_one(table_run(tmp_path, lambda s: 0 * s))
    assert (place, doubt) == ("rig.toml: inputs.speed", "always 0, while the table moves by 98 mm")


def test_a_position_in_metres(tmp_path):
    place, _, fix = the_one(table_run(tmp_path, lambda s: 10.0 * ((s > 100) & (s < 300)), metres=True))
    assert (place, fix) == ("rig.toml: inputs.position", "then scale = 1000")


def test_all_in_fahrenheit(rod):
    for name in ("air_C", "chiller_C", *(f"TC{k}" for k in range(1, 9))):
        cells(rod / "check.csv", name, lambda value: 32 + 1.8 * value)
    assert ("rig.toml: channels", "then scale = 0.5555555556, offset = -17.7777777778") in [
        (one["place"], one["fix"]) for one in doubts(rod)
    ]


# --- as a command


def test_guesses_of_init_are_one_doubt_until_their_marks_are_gone(tmp_path):
    assert ballscrew("init", ROD / "check.csv", "-o", tmp_path / "rod")[0] == 0
    place, doubt, fix = the_one(tmp_path / "rod")
    assert (place, "lines are guesses of `ballscrew init`" in doubt, fix) == (
        "rig.toml", True, "look at each, and take its mark away",
    )  # fmt: skip
    assert doubts(put(tmp_path / "rod", (" # guessed:.*", ""))) == []


def test_a_doubt_in_several_recordings_is_one_line(tmp_path):
    folder = tmp_path / "rod"
    shutil.copytree(ROD, folder, ignore=shutil.ignore_patterns("__pycache__"))
    put(folder, ("tick_s = 5.0", "tick_s = 1.0"))
    status, out, _ = ballscrew("check", folder)
    assert (status, out.count("tick_s is 1;")) == (0, 1)
    assert "(check.csv, pulses.csv, slow.csv ...)" in out


def test_a_log_that_cannot_be_used_and_a_rig_that_is_wrong(rod):
    (rod / "torn.blf").write_bytes(b"LOGG and nothing more")
    out, err = ended(1, "check", rod)
    assert "no doubt" in out
    assert err.startswith("error: ")
    put(rod, ("outer_mm", "outer"))
    status, _, err = ballscrew("check", rod)
    assert (status, "has no 'outer'" in err) == (2, True)


def test_a_recording_in_the_place_of_the_folder_is_told_apart(rod):
    status, _, err = ballscrew("check", rod / "check.csv")
    assert (status, "check.csv: is a file; name the rig folder first" in err) == (2, True)
    (rod / "rig.toml").unlink()
    status, _, err = ballscrew("check", rod)
    assert (status, f"{rod}: has no rig.toml; `ballscrew init LOG -o {rod}` writes a first one" in err) == (2, True)
