"""The command line: what it prints, what it writes, and how it ends."""

import json
import shutil
import signal
import subprocess
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

from ballscrew.cli import COMMANDS
from ballscrew.muting import muted
from ballscrew.options import all_named
from tests.conftest import ballscrew as run, ended, json_of
from tests.processes import PATIENCE_S, started

ESTIMATES = ["filter", "smoothed", "open_loop", "polyline", "polyline_7", "polyline_joined", "last_reading"]


def reviewed(*words: object) -> dict:
    """The one recording in the JSON of a review that must succeed."""
    (recording,) = json_of("review", *words)["recordings"]
    return recording


@pytest.fixture
def log(short_log, fs20_log, tmp_path) -> Path:
    """A part of FS-20 with its truth, in a folder of its own."""
    shutil.copy(fs20_log.with_name("FS-20.truth.csv"), tmp_path)
    return Path(shutil.copy(short_log, tmp_path))


@pytest.fixture(scope="module")
def plain(fs20_log):
    """The review of FS-20 as it is."""
    return reviewed(fs20_log)


@pytest.fixture(scope="module")
def torn(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("torn") / "torn.blf"
    path.write_bytes(b"LOGG and nothing more")
    return path


def test_help_lists_every_command():
    out, _ = ended(0, "--help")
    assert all(name in out and sentence in out for name, sentence in COMMANDS.items())


@pytest.mark.parametrize(
    ("name", "options"),
    [
        (
            "simulate",
            ["--machine", "--seed", "--plant", "--without", "--max-drive", "--cycles", "--seconds", "--interface"],
        ),
        ("review", ["--rig", "--model", "--channels", "--no-displacement", "--mute", "--save", "--json", "--quiet"]),
        ("fit", ["--rig", "--model", "-o MODEL", "--json", "--debug"]),
        ("tune", ["--rig", "--model", "-o MODEL", "--save", "--json", "--quiet"]),
        ("show", ["MODEL", "--json", "--debug"]),
    ],
)
def test_help_of_each_command_names_its_options(name, options):
    out, _ = ended(0, name, "--help")
    assert all(option in out for option in options)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ("simulate FS-20", "say where to: -o FILE for a recording, or --interface for a bus"),
        ("simulate FS-20 -o a.log --date 0001-01-01", "--date is of a recording, from 1980 to 2099"),
        ("simulate FS-20 --interface virtual --date 2026-11-03", "frames on a bus are of now"),
        ("simulate FX-20 -o a.log", "error: unknown experiment 'FX-20'; did you mean 'FS-20'?"),
        ("simulate FS-20 -o a.log --plant motor_heat=x", "'x' is no number; write motor_heat=0.5"),
        ("simulate FS-20 -o a.log --max-drive 2d", "'2d' is no time; write 2h, 90min, 45s or seconds"),
        ("simulate FS-20 -o a.xyz --seconds 2", "error: a.xyz: "),
        ("simulate FS-20 -o a.txt", "error: a.txt: cannot write '.txt'; known: .asc, .blf, .log, .mf4, .trc"),
        ("simulate FS-20 -o a.log --seconds -3", "-3.0 is not in the range x>0.0"),
        ("simulate FS-20 -o a.log --machine -1", "-1 is not in the range x>=0"),
        ("simulate FS-20 -o a.log --cycles 0", "0 is not in the range x>=1"),
        ("simulate FS-20 --interface virtual --speed-up 0", "0.0 is not in the range x>0.0"),
        ("simulate FS-20 -o a.log --interface virtual", "either -o FILE for a recording, or --interface"),
        ("review a.log --save a.csv", "error: --save a.csv: views are written as .rrd"),
        ("reviw", "No such command 'reviw'"),
        ("review", "Missing argument 'LOG...'"),
        ("review a.log --colour", "No such option '--colour'"),
        ("fit a.log", "Missing option '-o'"),
        ("tune a.log", "Missing option '-o'"),
        ("show none.toml", "error: none.toml: no such file"),
    ],
)
def test_wrong_usage_is_said_in_a_line_and_ends_with_2(words, text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    _, err = ended(2, *words.split())
    assert text in err
    assert "Traceback" not in err


def test_review_as_json(plain):
    assert plain["name"] == "FS-20.log"
    assert plain["reference"] == "truth"
    assert plain["ticks"] == pytest.approx(420, abs=2)
    assert plain["frames"] > 5000
    assert plain["seconds"] > 0
    assert 0.1 < plain["nis_mean"] < 3
    assert isinstance(plain["skipped"], dict)
    for name in ESTIMATES:
        lowest, highest = plain[name]["band_um"]
        assert lowest <= highest
        assert plain[name]["rms_um"] <= max(-lowest, highest)
    assert plain["polyline"]["channels"] == 15
    assert 0 <= plain["filter"]["coverage_2sigma"] <= 1
    assert plain["filter"]["cooldown_max_um"] <= max(map(abs, plain["filter"]["band_um"])) + 1e-5


def test_the_filter_beats_the_polyline_and_the_held_reading(plain):
    assert plain["filter"]["rms_um"] < 0.5 * plain["polyline"]["rms_um"]
    assert plain["filter"]["rms_um"] < 0.5 * plain["last_reading"]["rms_um"]
    assert np.ptp(plain["filter"]["band_um"]) < np.ptp(plain["polyline"]["band_um"])


def test_bands_are_reference_minus_estimate(log):
    plain = reviewed(log)
    truth = log.with_name("FS-20.truth.csv")
    head, *rows = truth.read_text().splitlines()
    split = [row.split(",") for row in rows]
    truth.write_text("\n".join([head, *(",".join([t, str(float(um) + 7.0), *rest]) for t, um, *rest in split)]) + "\n")
    shifted = reviewed(log)
    for name in ESTIMATES:
        assert shifted[name]["band_um"] == pytest.approx(np.array(plain[name]["band_um"]) + 7.0, abs=1e-3)


def test_without_truth_the_readings_are_the_reference(log, plain):
    log.with_name("FS-20.truth.csv").unlink()
    found = reviewed(log)
    assert found["reference"] == "readings"
    assert found["polyline"]["band_um"] == pytest.approx(plain["polyline"]["band_um"], abs=1.0)
    assert found["filter"]["band_um"] != plain["filter"]["band_um"]


def test_channels_choose_the_thermometers(fs20_log, plain):
    for words in ("2,4,5,6,8,12,15", "T02,T04,T05,T06,T08,T12,T15"):
        found = reviewed(fs20_log, "--channels", words)
        assert found["polyline"]["channels"] == 7
        assert found["polyline"]["band_um"] == pytest.approx(plain["polyline_7"]["band_um"], abs=1e-4)
        assert found["filter"]["rms_um"] != plain["filter"]["rms_um"]
    _, err = ended(2, "review", fs20_log, "--channels", "2,16")
    assert "error: --channels 16: no such thermometer" in err


def test_no_displacement_and_mute_take_readings_away(fs20_log, plain):
    blind = reviewed(fs20_log, "--no-displacement")
    same = reviewed(fs20_log, "--mute", "displacement:0")
    assert blind["filter"]["rms_um"] != plain["filter"]["rms_um"]
    assert same["filter"]["band_um"] == pytest.approx(blind["filter"]["band_um"], abs=1e-4)
    assert blind["polyline"] == plain["polyline"]
    late = reviewed(fs20_log, "--mute", "telemeter:stop1+2h", "--mute", "displacement:stop1")
    assert late["filter"]["cooldown_max_um"] != plain["filter"]["cooldown_max_um"]
    assert late["filter"]["band_um"] != blind["filter"]["band_um"]


@pytest.mark.parametrize(
    ("span", "text"),
    [
        ("telemeter", "--mute telemeter: write NAME:FROM, NAME:FROM-TO or NAME:FROM+TIME, like telemeter:stop1+60min"),
        ("telemeter:stop2", "error: --mute telemeter:stop2: FS-20.log has 1 stops"),
        ("telemeter:soon", "error: --mute telemeter:soon: 'soon' is neither seconds nor stop1, stop2, ..."),
        ("T07:1e9", "error: --mute T07:1e9: FS-20.log ends at "),
        ("T7:5", "no channel 'T7'; did you mean 'T07'?"),
        ("T07:100+soon", "error: --mute T07:100+soon: 'soon' is no time; write 2h, 90min, 45s or seconds"),
        ("T07:100-50", "error: --mute T07:100-50: it ends (50) before it begins (100)"),
        ("T07:stop1-5", "T07:stop1-5: it ends (5) before it begins (stop1)"),
    ],
)
def test_what_a_mute_gets_wrong_is_named(fs20_log, span, text):
    _, err = ended(2, "review", fs20_log, "--mute", span)
    assert text in err


def test_one_bad_log_leaves_the_others_in_use(log, torn):
    out, err = ended(1, "review", torn, log, "--json")
    assert f"error: {torn}" in err
    assert [r["name"] for r in json.loads(out)["recordings"]] == ["FS-20.log"]
    assert run("review", torn)[0] == 1
    assert run("review", log.with_name("none.log"))[0] == 1


def test_json_before_a_log_does_not_overwrite_it(log):
    before = log.read_bytes()
    out, _ = ended(0, "review", "--json", log)
    assert log.read_bytes() == before
    assert json.loads(out)["recordings"][0]["name"] == "FS-20.log"


def test_json_goes_to_its_file_and_tables_to_the_screen(log, tmp_path):
    out, _ = ended(0, "review", log, "--json", tmp_path / "r.json")
    assert "polyline" in out
    assert set(json.loads((tmp_path / "r.json").read_text())) == {"recordings", "overall", "held_out", "machine"}
    assert "polyline" in run("review", log, "--json")[2]
    status, out, _ = run("review", log, "--quiet")
    assert (status, out) == (0, "")


def test_json_may_be_written_twice_whatever_its_name(log, tmp_path):
    for _ in range(2):
        ended(0, "review", "--json", tmp_path / "out.txt", log)
        assert json.loads((tmp_path / "out.txt").read_text())["recordings"][0]["name"] == "FS-20.log"


@pytest.mark.parametrize(
    ("command", "option"),
    [("fit", "-o"), ("tune", "-o"), ("tune", "--save"), ("review", "--json"), ("review", "--save")],
)
def test_a_result_that_cannot_be_written_is_refused_before_the_work(command, option, log, tmp_path):
    work = mock.patch("ballscrew.workspace.load", side_effect=AssertionError("worked"))
    with work:
        status, _, err = run(command, log, option, tmp_path / "none" / "x.json")
    assert status == 2
    assert f"error: {tmp_path / 'none' / 'x.json'}: there is no folder {tmp_path / 'none'}" in err


def test_a_mute_from_zero_begins_with_the_first_sample(rig, driven):
    run = driven(rig, 20)
    mute = muted(run, rig, None, False, ["T07:0", "T03:5-9"])
    assert list(np.flatnonzero(mute(float(run.time_s[0])))) == [6]
    assert list(np.flatnonzero(mute(float(run.time_s[0]) + 7))) == [2, 6]
    assert list(np.flatnonzero(mute(float(run.time_s[-1])))) == [6]


def test_ctrl_c_ends_with_130():
    words = ["simulate", "FS-20", "--seconds", "60", "--interface", "virtual", "--channel", "tests"]
    with started("ballscrew", *words, stderr=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert "playing FS-20 on virtual tests" in process.stdout.readline()
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert "stopped by Ctrl-C" in err
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("suggest a.log --held-out b.log c.log --json", "suggest a.log --held-out b.log --held-out c.log --json"),
        ("improve a.log --held-out b.log c.log -o m.toml", "improve a.log --held-out b.log --held-out c.log -o m.toml"),
        ("simulate FS-20 --bus-kwargs host=h port=1", "simulate FS-20 --bus-kwargs host=h --bus-kwargs port=1"),
        ("suggest a.log b.log --held-out c", "suggest a.log b.log --held-out c"),
        ("suggest a.log --held-out --json", "suggest a.log --held-out --json"),
        ("review a.log --channels 2,4", "review a.log --channels 2,4"),
    ],
)
def test_every_word_after_an_option_for_many_belongs_to_it(given, meant):
    """A shell's more/*.log after --held-out must not be taken for recordings to fit."""
    assert all_named(given.split()) == meant.split()


@pytest.mark.parametrize("words", [("review", "--json={}"), ("fit", "-o", "{}"), ("tune", "-o", "{}")])
def test_no_result_is_written_over_a_recording(tmp_path, words):
    log = tmp_path / "check.csv"
    log.write_text("time,TC1\n")
    command, *rest = words
    _, err = ended(2, command, log, *(word.format(log) for word in rest))
    assert f"{log}: the name of a recording; choose another" in err
    assert log.read_text() == "time,TC1\n"
