"""`ballscrew init`: from recordings of a rig that nobody has described to a folder that reviews."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from tests.ballscrew.new_rig import foreign
from tests.conftest import ballscrew

ROD = foreign.ROOT / "examples" / "heated_rod" / "check.csv"
TWO = foreign.ROOT / "examples" / "two_heaters" / "first.csv"


def made(*words: object) -> dict:
    """The JSON of an init that must succeed."""
    status, out, err = ballscrew("init", *words, "--json")
    assert status == 0, err
    return json.loads(out)


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
        status, _, err = ballscrew(*words)
        assert status == 0, err


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
    status, _, err = ballscrew("review", tmp_path / "rig")
    assert status == 0, err


def test_a_dbc_of_another_bus_is_named(fs20_log, bus, tmp_path):
    status, err = refused(fs20_log, "--dbc", bus[1], "-o", tmp_path / "rig")
    assert status == 2
    assert "anlage.dbc: none of its ids, 0x310 (Spindel1)" in err


# --- a lab CSV


def test_a_rod_with_a_heater(tmp_path):
    told = made(ROD, "-o", tmp_path / "rod")
    assert roles(told) == {f"TC{k}": "thermometer" for k in range(1, 9)} | {
        "chiller_C": "temperature", "air_C": "ambient", "heater_W": "heater",
    }  # fmt: skip
    rig, model = load_rig(tmp_path / "rod"), load_model(tmp_path / "rod" / "model.toml")
    assert (rig.tick_s, rig.log.time_column, rig.nut, rig.supports) == (5.0, "t_s", None, {})
    assert [*model.effects] == ["conduction", "still_air", "thermometers", "heater"]
    assert model["heater.power"] == 1.0
    assert model["heater.at"] == rig.channels["TC1"].at_mm
    assert ("where each heater is", "at in model.toml") in [(one["what"], one["lines"]) for one in told["unknown"]]
    text = (tmp_path / "rod" / "model.toml").read_text()
    (tmp_path / "rod" / "model.toml").write_text(re.sub(r"\nat = \S+", "\nat = -15.0", text))  # beyond the ends as yet
    load_model(tmp_path / "rod" / "model.toml")
    assert ballscrew("review", tmp_path / "rod")[0] == 0


def test_two_thermometers_are_on_two_bodies_and_begin_as_they_warmed(tmp_path):
    made(TWO, "-o", tmp_path / "two")
    rig, model = load_rig(tmp_path / "two"), load_model(tmp_path / "two" / "model.toml")
    assert (rig.screw, rig.bodies) == (None, ("body_1", "body_2"))
    known = load_model(TWO.with_name("model.toml"))
    for mine, theirs in (("heater1.power", "heater_power.first"), ("bodies.g", "loss_to_air.g")):
        ratio = model[mine] / model["bodies.capacity"] / (known[theirs] / known["bodies.capacity"])
        assert 0.3 < ratio < 2.0
    assert ballscrew("review", tmp_path / "two")[0] == 0


HEADS = ["Zeit [s]", "Temp 1 [°C]", "Temp 2 [°C]", "Temp 3 [°C]", "Raumluft [K]", "Drehzahl [1/min]", "Lage [mm]"]


def screw_rows(count: int = 200) -> list[list[float]]:
    """A screw that is driven to and fro, warms and grows: s, three degC, air in K, rpm, mm."""
    s = np.arange(count) * 1.0
    warm = 5 * (1 - np.exp(-s / 60))
    rpm, place = 1000 * np.sign(np.sin(s / 10)), 100 + 100 * np.abs((s / 10 / np.pi) % 2 - 1)
    return np.column_stack([s, 20 + warm, 20.5 + 1.2 * warm, 21 + warm, 295 + 0 * s, rpm, place]).tolist()


def csv(path: Path, heads: list[str], rows: list[list[float]], sep: str = ";", head: str = "") -> Path:
    lines = [sep.join(heads), *(sep.join(f"{cell:.3f}".replace(".", ",") for cell in row) for row in rows), ""]
    path.write_text(head + "\n".join(lines), encoding="utf-8")
    return path


def test_a_german_lab_csv_with_units_in_brackets(tmp_path):
    path = csv(tmp_path / "lauf.csv", HEADS, screw_rows(), head="Anlage 7\nSerie 12\n\n")
    told = made(path, "-o", tmp_path / "rig")
    found = {one["name"]: (one["taken_as"], one["unit"]) for one in told["signals"]}
    assert found["ambient"] == ("ambient", "K")
    assert found["speed"] == ("speed", "rpm")
    assert found["position"] == ("position", "mm")
    rig = load_rig(tmp_path / "rig")
    assert (rig.inputs["ambient"].unit, rig.inputs["ambient"].offset) == ("degC", -273.15)
    assert [*rig.thermometers] == HEADS[1:4]
    assert rig.nut is not None
    assert "nut_friction" in load_model(tmp_path / "rig" / "model.toml").effects
    status, _, err = ballscrew("review", tmp_path / "rig")
    assert status == 0, err


def test_of_two_speeds_the_one_that_moves_the_table_is_taken_and_the_other_said(tmp_path):
    rows = [[*row, 500.0 + k % 3] for k, row in enumerate(screw_rows())]
    told = made(csv(tmp_path / "run.csv", [*HEADS, "Drehzahl Pumpe [1/min]"], rows), "-o", tmp_path / "rig")
    (speed,) = [one for one in told["signals"] if one["taken_as"] == "speed"]
    assert (speed["signal"], speed["or"]) == ("Drehzahl [1/min]", ["Drehzahl Pumpe [1/min]"])
    assert "or Drehzahl Pumpe [1/min]; edit" in (tmp_path / "rig" / "rig.toml").read_text()


def test_several_recordings_are_one_guess_and_each_has_its_own_zero(tmp_path):
    """Of two that grow one after the other the zeros differ by more than the growth."""
    heads = [*HEADS, "Dehnung [um]"]
    for name, zero, air in (("a.csv", 0.0, 0.0), ("b.csv", 400.0, -6.0)):
        rows = [[row[0], *(one + air for one in row[1:4]), *row[4:], zero + 10 * (row[1] - 20)] for row in screw_rows()]
        csv(tmp_path / name, heads, rows)
    told = made(tmp_path, "-o", tmp_path / "rig")
    assert {"a.csv", "b.csv"} <= {*told["files"]}
    rig = load_rig(tmp_path / "rig")
    assert rig.channels["displacement"].scale == 1.0
    assert rig.inputs["position"].lo <= 100.0 < 200.0 <= rig.inputs["position"].hi
    assert ballscrew("review", tmp_path / "rig")[0] == 0


def test_a_growth_that_shrinks_as_the_screw_warms_is_turned_round(tmp_path):
    rows = [[*row, -0.05 * (row[1] - 20)] for row in screw_rows()]
    made(csv(tmp_path / "run.csv", [*HEADS, "Dehnung [mm]"], rows), "-o", tmp_path / "rig")
    assert load_rig(tmp_path / "rig").channels["displacement"].scale == -1000.0


def test_what_is_of_no_rig_is_left_out_and_names_are_apart(tmp_path):
    """Torque, humidity and vibration have units that look like others; two currents and a wanted temperature."""
    more = ["Moment [Nm]", "Feuchte [%]", "Vibration [mm/s]", "Strom 1 [A]", "Strom 2 [A]", "T Soll [°C]", "P [kW]"]
    rows = [
        [*row, 3.0 + k % 2, 40.0, 0.3 + 0.1 * (k % 3), 2.0 + k % 4, 1.0, 21.0, 0.4]
        for k, row in enumerate(screw_rows())
    ]
    told = made(csv(tmp_path / "run.csv", [*HEADS, *more], rows), "-o", tmp_path / "rig")
    assert set(told["not_used"]) == {*more[:3]}
    found = {one["signal"]: (one["name"], one["taken_as"]) for one in told["signals"]}
    assert (found["Strom 1 [A]"][0], found["Strom 2 [A]"][0]) == ("current", "current_2")
    assert found["T Soll [°C]"][1] == "temperature"
    assert found["P [kW]"] == ("p", "power")
    assert not (tmp_path / "rig" / "effects.py").exists()
    assert ballscrew("review", tmp_path / "rig")[0] == 0


@pytest.mark.parametrize(
    ("times", "heads", "tick_s"),
    [
        (lambda s: s * 1000, "t_ms", 5.0),
        (lambda s: s * 1000, "t", 5.0),
        (lambda s: 1.7e12 + s * 1000, "timestamp", 5.0),
        (lambda s: s / 60, "time [min]", 5.0),
        (lambda s: 12 * s, "t", 60.0),
        (lambda s: s / 50, "t", 1.0),
    ],
    ids=["ms", "ms unsaid", "epoch", "minutes", "each minute", "ten a second"],
)
def test_times_are_read_in_whatever_they_count(tmp_path, times, heads, tick_s):
    rows = [[times(5.0 * k), 20 + k / 20, 21 + k / 25, 22 + k / 30] for k in range(200)]
    path = tmp_path / "run.csv"
    lines = [",".join(f"{cell:.9g}" if j else f"{cell:.3f}" for j, cell in enumerate(row)) for row in rows]
    path.write_text("\n".join([f"{heads},T1,T2,T3", *lines, ""]))
    assert made(path, "-o", tmp_path / "rig")["tick_s"] == pytest.approx(tick_s)
    assert ballscrew("review", tmp_path / "rig")[0] == 0


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
