"""`ballscrew init` from lab CSVs: a rod, two bodies, a screw whose columns are named in German."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from tests.ballscrew.new_rig.test_new_rig import ROD, TWO, made, roles
from tests.conftest import ballscrew, ended


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
        assert model.values[mine].sd == pytest.approx(model[mine])  # nobody has fitted it: a search may move it
    assert "q = P heater_1, into" in (tmp_path / "two" / "effects.py").read_text(), (
        "though it was on at the first sample"
    )
    assert ballscrew("review", tmp_path / "two")[0] == 0


@pytest.mark.parametrize(("step_K", "sd_K"), [(0.001, 0.05), (0.5, 0.144)])
def test_thermometers_scatter_as_the_recording_shows(tmp_path, step_K, sd_K):
    """By 0.05 K about the line through their neighbours, or by the half kelvins that they read in."""
    names, *rows = TWO.read_text().splitlines()
    at = [k for k, name in enumerate(names.split(",")) if name in ("T1", "T2")]
    cells = [row.split(",") for row in rows]
    for row in cells:
        for k in at:
            row[k] = f"{round(float(row[k]) / step_K) * step_K:.3f}"
    (tmp_path / "two.csv").write_text("\n".join([names, *map(",".join, cells), ""]))
    made(tmp_path / "two.csv", "-o", tmp_path / "two")
    assert load_model(tmp_path / "two" / "model.toml")["thermometers.sd"] == pytest.approx(sd_K, rel=0.1)


def test_a_heater_that_is_on_or_off_heats_and_stamps_of_each_thermometer_are_none(tmp_path):
    """As a small computer's script writes it: the time of each reading beside it, and words of the heater."""
    on = [k % 40 < 10 for k in range(200)]
    warm = 22.0 + 0.1 * np.cumsum(np.where(on, 1.0, -1.0 / 3.0))
    rows = [
        f"{1.6e9 + 3 * k},{'True' if on[k] else 'False'},{warm[k]:.3f},{1.6e9 + 3 * k - 1},{22 + k % 2 / 16:.3f},"
        f"{1.6e9 + 3 * k}" for k in range(200)
    ]  # fmt: skip
    (tmp_path / "box.csv").write_text("\n".join(["time,heater_on,t1,time_t1,t2,time_t2", *rows, ""]))
    told = made(tmp_path / "box.csv", "-o", tmp_path / "box")
    assert roles(told) == {"t1": "thermometer", "t2": "thermometer", "heater_on": "heater"}
    assert load_rig(tmp_path / "box").inputs["heater_on"].unit == "1"
    assert load_model(tmp_path / "box" / "model.toml")["heater_on.power"] == pytest.approx(50.0 * 0.033, rel=0.5)
    assert 'u["heater_on"]' in (tmp_path / "box" / "effects.py").read_text()


def test_what_two_bodies_may_lack_stands_beside_and_is_found(tmp_path):
    """In no model, in effects.py: two heaters that warm each other, of columns that end in a unit."""
    for path in sorted(TWO.parent.glob("*.csv")):
        (tmp_path / path.name).write_text(path.read_text().replace("heater_1,heater_2", "heater_1_%,heater_2_%", 1))
    made(*sorted(tmp_path.glob("*.csv")), "-o", tmp_path / "rig")
    assert [*load_model(tmp_path / "rig" / "model.toml").effects] == ["thermometers", "bodies", "heater1", "heater2"]
    assert ballscrew("effects", tmp_path / "rig" / "effects.py", "--check")[0] == 0
    fitted = tmp_path / "rig" / "fitted.toml"
    assert ballscrew("fit", tmp_path / "rig", "-o", fitted)[0] == 0
    said = json.loads(ballscrew("suggest", tmp_path / "rig", "--model", fitted, "--json", "--quiet")[1])
    assert "coupling" in (said["pair"] or [said["effects"][0]["name"]])


def test_of_volts_and_what_they_mean_the_temperatures_are_the_thermometers(tmp_path):
    """A logger writes what it read beside what it made of it."""
    rows = [
        ",".join([str(5 * k), *(f"{0.2 + 0.001 * k},{20 + 0.1 * k + place}" for place in range(4))]) for k in range(90)
    ]
    (tmp_path / "rod.csv").write_text("\n".join(["time,V1,T1,V2,T2,V3,T3,V4,T4", *rows, ""]))
    told = roles(made(tmp_path / "rod.csv", "-o", tmp_path / "rod"))
    assert [name for name, role in told.items() if role == "thermometer"] == ["T1", "T2", "T3", "T4"]


def test_a_csv_without_names_is_told_to_get_some(tmp_path):
    bare = tmp_path / "bare.csv"
    bare.write_text("0,0,299.5\n" * 60)  # two columns of one name, if these were names
    _, err = ended(1, "init", bare, "-o", tmp_path / "rig")
    assert "its first line holds numbers: write a line of names above it" in err


def mf4(path: Path, table: Path) -> Path:
    """The columns of a CSV as signals of an MF4, each in a group of its own, and one that is text."""
    asammdf = pytest.importorskip("asammdf")  # late: it takes most of a second
    names = table.read_text().partition("\n")[0].split(",")
    columns = np.loadtxt(table, delimiter=",", skiprows=1, unpack=True)
    with asammdf.MDF(version="4.10") as mdf:
        for name, column in zip(names[1:], columns[1:], strict=True):
            known = np.isfinite(column)
            unit = "W" if name.endswith("_W") else "degC"
            mdf.append([asammdf.Signal(column[known], columns[0][known], name=name, unit=unit)])
        mdf.append([asammdf.Signal(np.array([b"idle", b"on"]), np.arange(2.0), name="mode", encoding="utf-8")])
        mdf.save(str(path), overwrite=True)
    return path


def test_an_mf4_of_signals_is_the_rig_that_its_csv_is(tmp_path):
    signals = mf4(tmp_path / "rod.mf4", ROD)
    told, of_csv = made(signals, "-o", tmp_path / "rod"), made(ROD, "-o", tmp_path / "csv")
    assert roles(told) == roles(of_csv)
    assert load_rig(tmp_path / "rod").channels == load_rig(tmp_path / "csv").channels
    assert ballscrew("review", tmp_path / "rod")[0] == 0
    text = (tmp_path / "rod" / "rig.toml").read_text()
    assert "time_column" not in text
    (tmp_path / "rod" / "rig.toml").write_text(text.replace("TC3 = {", 'TC3 = {column = "mode", '))
    out, _ = ended(0, "check", tmp_path / "rod")
    assert "rig.toml: channels.TC3: column 'mode' holds no number; look at that sensor and its logger" in out
    assert "it names none of these temperatures: TC3" in out


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
    ended(0, "review", tmp_path / "rig")


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
