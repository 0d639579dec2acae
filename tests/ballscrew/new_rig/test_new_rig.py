"""`ballscrew init`: from recordings of a rig that nobody has described to a folder that reviews."""

import re
import shlex
from pathlib import Path

import pytest

from estimator.rig_folder.rig_folder import load_rig
from tests.ballscrew.new_rig import foreign
from tests.conftest import ballscrew, ended, json_of

ROD = foreign.ROOT / "examples" / "heated_rod" / "check.csv"
TWO = foreign.ROOT / "examples" / "two_heaters" / "first.csv"


def made(*words: object) -> dict:
    """What an init that must succeed has made."""
    return json_of("init", *words)


def refused(*words: object) -> tuple[int, str]:
    """Status and the one line of an init that must not succeed."""
    status, out, err = ballscrew("init", *words)
    assert out == ""
    assert len(err.splitlines()) == 1
    return status, err


def roles(told: dict) -> dict[str, str]:
    """What each signal is taken as."""
    return {one["signal"]: one["taken_as"] for one in told["signals"]}


@pytest.fixture(scope="module")
def bus(fs20_log, tmp_path_factory) -> tuple[Path, Path]:
    """A log of a foreign bus, and its DBC."""
    folder = tmp_path_factory.mktemp("bus")
    return foreign.log(folder / "fremd.log", fs20_log), foreign.dbc(folder / "anlage.dbc")


@pytest.fixture(scope="module")
def german(bus, tmp_path_factory) -> tuple[Path, dict]:
    """The rig folder made of it, and what was said."""
    folder = tmp_path_factory.mktemp("made") / "rig"
    return folder, made(bus[0], "--dbc", bus[1], "-o", folder)


# --- a log of CAN frames


def test_every_signal_of_a_foreign_bus_is_taken_for_what_it_is(german):
    found = roles(german[1])
    assert [source for source, role in found.items() if role == "thermometer"] == [
        f"Spindel{1 + k // 4}.Temp_{k + 1}" for k in range(15)
    ]
    rest = {source.partition(".")[2]: role for source, role in found.items() if role != "thermometer"}
    assert rest == {
        "Platine": "board", "Umgebungsluft": "ambient", "Maschinenbett": "base", "Festlager": "anchor_bracket",
        "Loslager": "free_bracket", "Mutter": "nut", "Messtaster": "probe", "Messstange": "bar", "Drehzahl": "speed",
        "Lage": "position", "Strom": "current", "HubA1B1": "displacement", "RuheA1B1": "displacement_direct",
    }  # fmt: skip


def test_what_is_written_reads_and_holds_what_was_checked(german):
    rig = load_rig(german[0])
    log = rig.log
    assert (log.dbc, log.closes, log.scan) == ("anlage.dbc", "SpindelEnde", tuple(f"Spindel{k}" for k in range(1, 5)))
    assert (log.scan_crc, log.scan_number) == ("SpindelEnde.AbtastCrc", "SpindelEnde.AbtastNo")
    assert log.scan_state == "SpindelEnde.TelState = Ok"
    assert {"Achse.DrvCounter", "Klima2.EnvCounter", "SpindelEnde.TelCounter"} <= {*log.counters}
    assert log.checksums == ()  # it is over the id, which is another on this bus
    assert rig.tick_s == 1.0
    assert rig.screw is not None
    assert rig.screw.lead_mm == pytest.approx(12.0, rel=0.01)
    displacement = rig.channels["displacement"]
    assert (displacement.signals, displacement.scale) == (("Laengung1.HubA1B1", "Laengung1.HubA2B2"), 0.5)
    assert (displacement.fresh, displacement.valid) == ("Laengung1.HubSeq", "Laengung1.HubState = Ok")


def test_every_guess_is_marked_and_lines_are_named(german):
    folder, told = german
    lines = (folder / "rig.toml").read_text().splitlines()
    for name in ("outer_mm", "centre_mm", "density", "anchor", "Temp_1", "speed", "closes"):
        (line,) = [line for line in lines if line.startswith(f"{name} =")]
        assert re.search(r"# guessed: .*; edit$", line)
    unknown = {one["what"]: one["lines"] for one in told["unknown"]}
    first, last = map(int, unknown["where each thermometer is"].split(" - "))
    assert lines[first - 1].startswith("Temp_1 =")
    assert lines[last - 1].startswith("Temp_15 =")


def test_the_next_commands_work_as_printed(german):
    for line in german[1]["next"]:
        program, *words = shlex.split(line)
        assert program == "ballscrew"
        ended(0, *words)


def test_a_bus_without_units_is_read_by_names_and_numbers(bus, german, tmp_path):
    told = made(bus[0], "--dbc", foreign.dbc(tmp_path / "plain.dbc", units=False), "-o", tmp_path / "rig")
    expected = roles(german[1])
    assert {source: role for source, role in roles(told).items() if role != "current"} == {
        source: role for source, role in expected.items() if role != "current"
    }


def test_ids_that_nobody_knows_need_a_dbc(bus, tmp_path):
    status, err = refused(bus[0], "-o", tmp_path / "rig")
    assert status == 2
    assert "of 10 ids (0x330 " in err
    assert "--dbc FILE.dbc" in err
    assert not (tmp_path / "rig").exists()


def test_the_project_s_own_ids_need_none(fs20_log, tmp_path):
    told = made(fs20_log, "-o", tmp_path / "rig")
    assert told["files"] == ["rig.toml", "model.toml", "FS-20.log"]
    _, out, _ = ballscrew("init", fs20_log, "-o", tmp_path / "rig", "--force")
    assert "a tick closes with TelemeterStatus; right on this log: scan_crc, scan_number, checksums, counters" in out
    assert "Telemeter3.T09" in out
    assert load_rig(tmp_path / "rig").log.checksums == ("TelemeterStatus.TelCrc",)
    ended(0, "review", tmp_path / "rig")


def test_a_dbc_of_another_bus_is_named(fs20_log, bus, tmp_path):
    status, err = refused(fs20_log, "--dbc", bus[1], "-o", tmp_path / "rig")
    assert status == 2
    assert "anlage.dbc: none of its ids, 0x310 (Spindel1)" in err


# --- what is there, and what is refused


def test_nothing_is_overwritten_unless_asked(tmp_path):
    made(ROD, "-o", tmp_path / "rod")
    mine = (tmp_path / "rod" / "rig.toml").read_text() + "# mine\n"
    (tmp_path / "rod" / "rig.toml").write_text(mine)
    status, err = refused(ROD, "-o", tmp_path / "rod")
    assert status == 2
    assert "has rig.toml, model.toml, effects.py already; --force overwrites" in err
    assert (tmp_path / "rod" / "rig.toml").read_text() == mine
    made(ROD, "-o", tmp_path / "rod", "--force")
    assert (tmp_path / "rod" / "rig.toml").read_text() != mine


def test_places_may_be_given_at_once(tmp_path):
    made(ROD, "-o", tmp_path / "rod", "--places", "40,75,120,170,225,280,330,375")
    rig = load_rig(tmp_path / "rod")
    assert [channel.at_mm for channel in rig.channels.values()] == [40, 75, 120, 170, 225, 280, 330, 375]
    assert "its place" not in (tmp_path / "rod" / "rig.toml").read_text()
    status, err = refused(ROD, "-o", tmp_path / "other", "--places", "1,2")
    assert (status, "--places: 2 of them, but 8 thermometers" in err) == (2, True)
    assert not (tmp_path / "other").exists()


def test_no_temperature_is_no_rig(tmp_path):
    path = tmp_path / "flow.csv"
    path.write_text("t_s,flow,pressure\n" + "".join(f"{k},{k % 7},{k % 5}\n" for k in range(50)))
    status, err = refused(path, "-o", tmp_path / "rig")
    assert status == 1
    assert "no thermometer on a screw or a body among flow, pressure" in err


def test_frames_and_tables_are_two_rigs(fs20_log, tmp_path):
    status, err = refused(fs20_log, ROD, "-o", tmp_path / "rig")
    assert status == 2
    assert "take one kind" in err
