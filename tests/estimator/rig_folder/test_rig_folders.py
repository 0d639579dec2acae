"""Rig folders: every example works from its files alone; what does not fit says so in one line."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from drivers.encoded import Encoded
from drivers.recordings import read_recording
from drivers.virtual_rig import simulate
from estimator.batch import nominal
from estimator.batch.replay import replay
from estimator.errors import SetupError
from estimator.filter import Filter
from estimator.inputs.inputs import nothing
from estimator.inputs.start import Start
from estimator.network.assemble import network_of
from estimator.network.discretise import transition
from estimator.network.forcing import Forcing
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from tests.conftest import EXAMPLES, ROD, ended

SEVEN = EXAMPLES / "seven_channels"
KNOWN = {"still_air.h": 9.0, "heater.share": 0.95, "chilled_end.g": 1.2}  # what made the rod's data


def ballscrew(*words: str | Path) -> str:
    """Run the command; returns what it wrote to stdout."""
    out, _ = ended(0, *words)
    return out


def loaded(text: str) -> dict:
    """JSON of the command; a number that is none would be no JSON."""

    def none(constant: str) -> None:
        raise AssertionError(f"{constant} in JSON")

    return json.loads(text, parse_constant=none)


def review(*words: str | Path) -> dict:
    """The JSON of a review."""
    return loaded(ballscrew("review", *words, "--json"))


@pytest.fixture(scope="module")
def seven(tmp_path_factory) -> Path:
    """A copy of the folder with a log: a drive of 222 s at 20 m/min and 16 min of its stop."""
    folder = tmp_path_factory.mktemp("rigs") / "seven"
    shutil.copytree(SEVEN, folder)
    (folder / "FS-20.blf").unlink()
    Encoded(simulate("FS-20", seconds=1200.0), load_rig(folder)).write(folder / "drive.log")
    return folder


def test_seven_channels_on_another_bus_are_reviewed(seven):
    found = review(seven)["recordings"]
    assert [one["name"] for one in found] == ["drive.log"]
    assert found[0]["reference"] == "truth"
    assert found[0]["skipped"] == {}
    assert found[0]["ticks"] == 1201
    lowest, highest = found[0]["filter"]["band_um"]
    assert highest - lowest < 0.8
    assert found[0]["filter"]["rms_um"] < 0.3
    assert found[0]["polyline"]["channels"] == 7
    assert highest - lowest < 0.2 * np.ptp(found[0]["polyline"]["band_um"])
    assert 0.3 < found[0]["nis_mean"] < 1.5


def test_seven_channels_without_truth_are_judged_by_their_readings(seven, tmp_path):
    shutil.copy(seven / "drive.log", tmp_path)
    found = review(tmp_path / "drive.log", "--rig", seven)["recordings"][0]
    assert found["reference"] == "readings"
    assert found["filter"]["rms_um"] < 0.5


def test_every_signal_of_the_other_bus_arrives(seven):
    lived, record = simulate("FS-20", seconds=100.0), read_recording(seven / "drive.log", load_rig(seven))
    np.testing.assert_allclose(record.channels[:101, 0], lived.measured.channels[:, 1], atol=0.011)
    np.testing.assert_allclose(record.inputs["ambient"][:101], lived.measured.environment.ambient, atol=0.051)
    at_rest = record.inputs["displacement_direct"][:20]
    np.testing.assert_allclose(at_rest, lived.measured.direct.elongation_um[:20], atol=0.001)
    assert np.nanmax(record.omega) == pytest.approx(174.5, abs=0.1)
    assert np.isnan(record.channels[:20, -1]).all()
    assert np.isfinite(record.channels[20:, -1]).sum() > 80


@pytest.fixture(scope="module")
def fitted(tmp_path_factory) -> Path:
    """A model fitted from guesses to the first run, in a folder of its own."""
    folder = tmp_path_factory.mktemp("rod")
    shutil.copy(ROD / "effects.py", folder)
    guesses = "".join(
        f"[{name}]\n{body}\n\n"
        for name, body in {
            "conduction": "noise = 0.05",
            "still_air": "h = 6.0",
            "heater": 'use = "effects.py:Heater"\nshare = 1.0',
            "chilled_end": 'use = "effects.py:ChilledEnd"\ng = 0.5',
            "thermometers": "sd = 0.05\ntau = { value = 4.0, fixed = true }\nboard = { value = 0.0, fixed = true }",
        }.items()
    )
    (folder / "guess.toml").write_text(guesses)
    out = folder / "elsewhere" / "fitted.toml"
    out.parent.mkdir()
    said = ballscrew("fit", ROD / "steps.csv", "--model", folder / "guess.toml", "-o", out, "--json", folder / "a.json")
    assert "nan" not in said
    after = json.loads((folder / "a.json").read_text())["open_loop"]["after"]
    assert after["elongation_um"] is None
    assert after["temperature_K"] < 0.06
    return out


@pytest.mark.parametrize(("path", "true"), KNOWN.items())
def test_a_fit_finds_what_made_the_rod_s_data(fitted, path, true):
    assert load_model(fitted)[path] == pytest.approx(true, rel=0.015)


@pytest.mark.parametrize(("path", "true"), KNOWN.items())
def test_the_rod_s_own_model_is_that_fit(fitted, path, true):
    assert load_model(ROD / "model.toml")[path] == pytest.approx(load_model(fitted)[path], rel=1e-3)


def test_the_rod_is_predicted_in_a_run_the_fit_never_saw(fitted):
    found = review(ROD / "check.csv", "--model", fitted)["recordings"][0]
    assert found["temperature_K"]["one_step"] < 0.055  # its thermocouples scatter by 0.05 K
    assert found["temperature_K"]["open_loop"] < 0.07
    assert 0.4 < found["nis_mean"] < 1.5


def test_a_rod_without_displacement_says_so_and_has_nulls_in_its_json(tmp_path):
    said = ballscrew("review", ROD, "--json", tmp_path / "found.json")
    assert "elongation not judged" in said
    assert "nan" not in said
    found = loaded((tmp_path / "found.json").read_text())
    for one in [*found["recordings"], found["overall"], found["held_out"]]:
        assert one["filter"] == {
            "band_um": [None, None], "rms_um": None, "cooldown_max_um": None, "coverage_2sigma": None
        }  # fmt: skip
        assert "last_reading" not in one
    assert [one["reference"] for one in found["recordings"]] == ["none"] * 4


def test_the_rod_is_saved_for_the_viewer(tmp_path):
    ballscrew("review", ROD / "check.csv", "--save", tmp_path / "rod.rrd", "--quiet")
    assert (tmp_path / "rod.rrd").stat().st_size > 10_000


def test_a_dial_gauge_at_rest_is_a_reference(tmp_path):
    """A displacement on a rig without a drive: read at any time, its zero unknown, the reference of a review."""
    shutil.copytree(ROD, tmp_path / "rod")
    rod = tmp_path / "rod"
    text = (rod / "rig.toml").read_text()
    gauge = 'displacement = { column = "gauge_mm", unit = "um", scale = 1000.0, lo = -5000.0, hi = 5000.0 }\n\n[inputs]'
    (rod / "rig.toml").write_text(text.replace("[inputs]", gauge))
    (rod / "model.toml").write_text((rod / "model.toml").read_text() + "\n[displacement]\nsd = 0.5\n")
    plain = read_recording(ROD / "check.csv", load_rig(ROD))
    grown = replay(load_model(ROD / "model.toml"), load_rig(ROD), plain).elongation_um
    rows = (rod / "check.csv").read_text().splitlines()
    cells = [f"{row},{3.0 + um / 1000:.6f}" for row, um in zip(rows[1:], grown, strict=False)]
    (rod / "check.csv").write_text("\n".join([rows[0] + ",gauge_mm", *cells, ""]))
    found = review(rod / "check.csv")["recordings"][0]
    assert found["reference"] == "readings"
    assert found["filter"]["rms_um"] < 0.5
    assert found["open_loop"]["rms_um"] < 1.5


@pytest.mark.parametrize(
    ("file", "old", "new", "says"),
    [
        ("rig.toml", "heater = {", "heating = {", "heater .*: needs the input 'heater', .* did you mean 'heating'"),
        ("rig.toml", "ambient = {", "air = {", "still_air: a Link ends at 'ambient'"),
        ("effects.py", "rig.screw.overlap", "rig.nut.overlap", "heater .effects.py:Heater.: line 16: AttributeError"),
        ("effects.py", "p.g *", 'p.g * u["heater"] *', "chilled_end .*: the g of a Link depends on an input"),
        ("model.toml", "[thermometers]", "[nut_friction]\n[thermometers]", "nut_friction: needs .nut., .* add it"),
        ("model.toml", "[thermometers]", "[displacement]\n[thermometers]", "displacement: reads 'displacement'"),
    ],
)  # fmt: skip
def test_an_effect_that_the_rig_cannot_serve_says_so_in_one_line(tmp_path, file, old, new, says):
    rod = tmp_path / "rod"
    shutil.copytree(ROD, rod)
    text = (rod / file).read_text()
    assert old in text
    (rod / file).write_text(text.replace(old, new, 1))
    found = load_rig(rod)
    judge = Filter(load_model(rod / "model.toml"), found)
    sample = read_recording(rod / "check.csv", found).sample(0)
    with pytest.raises(SetupError, match=says) as caught:
        judge.step(sample)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("at_mm = 375.0", "at_mm = 3750.0", "channels.TC8.at_mm = 3750 is outside the screw, 0 ... 400 mm"),
        ("to_mm = 400.0", "to_mm = -1.0", "screw: from_mm must be below to_mm"),
        ("tick_s = 5.0", "tick_s = 0", "tick_s is 0, must be 0.01 ... 3600 s"),
        ("tick_s = 5.0", 'tick_s = "5"', "tick_s: expected a number, got '5'"),
        ("hi = 50.0", "hi = 0.0", "heater: lo = 0 is not below hi = 0"),
        ("[log]", "[nut]\nlength_mm = 10.0\ncentre_mm = 5.0\n[log]", "[nut] needs the input 'position'"),
        ("[screw] ", "subset_7 = ['TC9']\n[screw] ", "subset_7: no thermometer 'TC9'; did you mean"),
        ("at_mm = 375.0", "at_mm = 375.0, node = 'x'", "channels.TC8 has both at_mm and node"),
    ],
)
def test_a_rig_file_that_contradicts_itself_says_where(tmp_path, old, new, says):
    text = (ROD / "rig.toml").read_text()
    assert old in text
    (tmp_path / "rig.toml").write_text(text.replace(old, new, 1))
    with pytest.raises(SetupError) as caught:
        load_rig(tmp_path)
    assert str(caught.value).startswith(f"{tmp_path / 'rig.toml'}: {says}")


def rod_forcing(reduced: bool = True) -> Forcing:
    found = load_rig(ROD)
    start = Start(22.0, 0.0, dict.fromkeys(found.inputs, 0.0))
    return Forcing(load_model(ROD / "model.toml"), found, start, reduced)


def test_the_rod_s_few_states_follow_its_two_hundred_slices():
    record = read_recording(ROD / "check.csv", load_rig(ROD))
    few, all_slices = (
        nominal.open_loop(forcing, forcing.read(record), np.full(forcing.place.size, 22.0), record.ages_s)
        for forcing in (rod_forcing(), rod_forcing(reduced=False))
    )
    assert few.shape == all_slices.shape
    assert np.abs(few - all_slices).max() < 0.05


@pytest.mark.parametrize("dt", [5.0, 20.0, 60.0, 600.0])
def test_a_long_tick_is_many_short_ones(dt):
    """Aluminium evens out within seconds: the noise of a long tick must not be lost in what has died out."""
    forcing = rod_forcing()
    still = nothing(forcing.rig)
    system = network_of(list(forcing.model.terms(still, forcing.rig)), forcing.place, len(still))
    short, long = transition(system, 0, 0.5), transition(system, 0, dt)
    F, J, Q = np.eye(len(short.F)), np.zeros_like(short.J), np.zeros_like(short.Q)
    for _ in range(int(dt / 0.5)):
        F, J, Q = short.F @ F, short.F @ J + short.J, short.F @ Q @ short.F.T + short.Q
    for many, one in ((F, long.F), (J, long.J), (Q, long.Q)):
        np.testing.assert_allclose(one, many, rtol=0, atol=1e-11 * np.abs(many).max())
