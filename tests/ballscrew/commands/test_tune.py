"""ballscrew tune: what it prints, writes and draws; and the innovations that it draws."""

import json
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

from ballscrew.report.tune_report import sentences
from drivers.recordings import read_recording
from estimator.accuracy.noise_floor import Error
from estimator.accuracy.quality import ChannelQuality, innovations, overall
from estimator.batch.trial import Trial
from estimator.fit.tune import Factors, Level, Tuned
from estimator.rig_folder.model_toml import load_model, save_model
from tests.conftest import PAPER, ROD, ballscrew as run, ended, json_of
from tests.viz_read import fixed, rows, view_names

ROWS = 16


@pytest.fixture(scope="module")
def tuned(fs20_log: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str, dict]:
    """Folder with model and views, what was printed, and the JSON, of a short recording and too quiet a model."""
    folder = tmp_path_factory.mktemp("tuned")
    text = (PAPER / "model.toml").read_text()
    sd = next(line for line in text.splitlines() if line.startswith("sd =") and line.endswith("# K"))
    (folder / "quiet.toml").write_text(text.replace(sd, "sd = 0.008 # K"))
    words = ["--model", folder / "quiet.toml", "-o", folder / "new.toml", "--save", folder / "t.rrd"]
    out, _ = ended(0, "tune", fs20_log, *words, "--json", folder / "t.json")
    return folder, out, json.loads((folder / "t.json").read_text())


def test_the_noise_goes_up_to_what_it_is_and_nis_down_to_one(tuned) -> None:
    folder, _, told = tuned
    level, nis = told["levels"]["thermometers.sd"], told["channels"]["T15"]["nis"]
    assert level["before"] == 0.008
    assert 0.01 < level["after"] < 0.03
    assert load_model(folder / "new.toml")["thermometers.sd"] == pytest.approx(level["after"], rel=1e-4)
    assert nis["after"] < 1.2
    assert nis["before"] > 2 * nis["after"]


def test_the_tables_fit_into_a_narrow_terminal(tuned) -> None:
    lines = tuned[1].splitlines()
    assert not [line for line in lines if "…" in line]
    assert sum("->" in line for line in lines) == ROWS + 2  # the channels, all together, and the title
    assert any(line.startswith("views: ") and "rerun" in line for line in lines)


def test_the_views_are_of_both_models(tuned, rig, fs20_log) -> None:
    folder, _, told = tuned
    trial = Trial(load_model(folder / "quiet.toml"), rig, read_recording(fs20_log, rig))
    for side, name in (("before", "quiet.toml"), ("after", "new.toml")):
        known = innovations(trial, load_model(folder / name)).scaled[:, 14]
        values = np.ravel(rows(folder / "t.rrd", f"/FS-20/scaled/{side}/T15/each", "Scalars:scalars")[1])
        np.testing.assert_allclose(values, known[np.isfinite(known)], rtol=1e-3, atol=1e-6)
        assert np.mean(values**2) == pytest.approx(told["channels"]["T15"]["nis"][side], rel=1e-3)
    text = fixed(folder / "t.rrd", "/summary", "TextDocument:text")[0]
    assert f"| thermometers.sd | measurement | 0.008 | {told['levels']['thermometers.sd']['after']:.4g} | K |" in text
    assert "| displacement | " in text
    assert "NIS a tick ahead [1]" in view_names(folder / "t.rrd")


def test_autocorrelation_is_one_at_lag_zero_and_whiteness_the_largest_other(tuned, rig, fs20_log) -> None:
    known = innovations(Trial(load_model(tuned[0] / "quiet.toml"), rig, read_recording(fs20_log, rig)),
                        load_model(tuned[0] / "new.toml"))  # fmt: skip
    assert known.lags_s.tolist() == list(range(61))
    assert known.autocorrelation.shape == (ROWS, 61)
    heat = known.autocorrelation[:15]
    np.testing.assert_allclose(heat[:, 0], 1.0)
    np.testing.assert_allclose(known.whiteness[:15], np.abs(heat[:, 1:]).max(axis=1))
    z = known.scaled[:, 3] - known.scaled[:, 3].mean()
    assert heat[3, 7] == pytest.approx((z[7:] @ z[:-7]) / np.sqrt(z[7:] @ z[7:] * (z[:-7] @ z[:-7])))


def test_all_channels_together_count_every_reading_alike() -> None:
    nan = float("nan")
    one, two = (
        ChannelQuality("A", 300, 1.0, 0.1, 0.9, 0, nan, nan),
        ChannelQuality("B", 100, 3.0, nan, 0.5, 4, 2.0, 1.0),
    )
    found = overall([one, two, ChannelQuality("C", 0, nan, nan, nan, 0, nan, nan)])
    assert found == ChannelQuality("all", 400, 1.5, 0.1, 0.8, 4, 2.0, 1.0)


def test_what_a_person_should_know_is_said() -> None:
    levels = Level("displacement.sd", "measurement", 0.15, 0.15, "um"), Level("conduction.noise", "process", 1, 4, "W")
    off = {"open_loop": Error(0.9, 1.0)}
    missing, louder, stays = sentences(Tuned(None, levels, Factors(4.0, 0.5), (), (), off, Error(0.1, 0.1), 9.0, ()))
    assert missing.startswith("noise stands in for missing physics here: the model alone is 0.90 K off, 9.0 times")
    assert louder.startswith("process noise rose 4.0 times")
    assert stays.startswith("not lowered: displacement.sd; innovations there are not white")
    fine = Level("displacement.sd", "measurement", 0.15, 0.1, "um"), Level("conduction.noise", "process", 1, 2, "W")
    assert sentences(Tuned(None, fine, Factors(2.0, 2.0), (), (), off, Error(0.1, 0.1), float("nan"), ())) == []


def test_tune_writes_a_model_of_other_noise_levels_and_nothing_else(rig_folder):
    """From thermometers said to be twice as good as they are."""
    out = rig_folder / "tuned.toml"
    save_model(load_model(rig_folder / "model.toml").with_values({"thermometers.sd": 0.01}), rig_folder / "model.toml")
    told = json_of("tune", rig_folder / "logs", "-o", out)
    before, after = load_model(rig_folder / "model.toml"), load_model(out)
    assert {level["of"] for level in told["levels"].values()} == {"measurement", "process"}
    for path, value in before.values.items():
        if path in told["levels"]:
            level = told["levels"][path]
            assert level["before"] == pytest.approx(value.value, rel=1e-4)
            assert after[path] == pytest.approx(level["after"], rel=1e-4), path
            assert after.values[path].fixed == value.fixed
        else:
            assert after.values[path] == value, path
    assert after["thermometers.sd"] > 0.015
    assert told["process_factors"]["others"] == 1.0  # seven minutes: nothing was blind for ten


def test_tune_says_in_a_table_what_changed_and_as_json_all_it_knows(tmp_path):
    """On the rod's committed run of more than an hour, from a model that is too sure of itself."""
    sure = {"conduction.noise": 0.02, "thermometers.sd": 0.1, "thermometers.lag_noise": 0.0}
    save_model(load_model(ROD / "model.toml").with_values(sure), tmp_path / "sure.toml")
    words = ["tune", ROD / "steps.csv", "--model", tmp_path / "sure.toml", "-o", tmp_path / "tuned.toml"]
    status, text, _ = run(*words, "--json", tmp_path / "tune.json")
    told = json.loads((tmp_path / "tune.json").read_text())
    assert status == 0
    assert {
        "levels", "channels", "errors", "noise_floor", "process_factors", "missing_physics", "sentences",
    } <= set(told)  # fmt: skip
    assert told["levels"]["thermometers.sd"]["after"] == pytest.approx(0.05, rel=0.05)
    assert told["levels"]["conduction.noise"]["after"] == pytest.approx(
        0.02 * told["process_factors"]["places"], rel=1e-4
    )
    assert told["channels"]["TC1"]["nis"]["after"] == pytest.approx(1.0, abs=0.15)
    assert told["noise_floor"]["elongation_um"] is None
    for path, level in told["levels"].items():
        (line,) = [line for line in text.splitlines() if line.startswith(path)]
        numbers = [f"{level[key]:.4g}" for key in ("before", "after")]
        assert " ".join(line.split()) == " ".join([path, level["of"], *numbers, level["unit"]])
    assert all(sentence in text for sentence in told["sentences"])
    assert f"model: {tmp_path / 'tuned.toml'}" in text
    assert load_model(tmp_path / "tuned.toml")["heater.share"] == load_model(ROD / "model.toml")["heater.share"]


def test_a_quiet_tune_is_silent_and_never_opens_the_truth(short_folder):
    (short_folder / "logs" / "FS-20.truth.csv").write_bytes(b"\xff not a table")
    opened = []
    real = Path.open
    spy = mock.patch.object(Path, "open", lambda self, *a, **k: opened.append(self.name) or real(self, *a, **k))
    with spy:
        assert run("tune", short_folder / "logs", "-o", short_folder / "tuned.toml", "--quiet") == (0, "", "")
    assert "FS-20.truth.csv" not in opened
    assert "model.toml" in opened
    assert set(load_model(short_folder / "tuned.toml").values) == set(load_model(short_folder / "model.toml").values)


def test_ctrl_c_in_tuning_ends_with_130_and_no_model(tmp_path):
    interrupt = mock.patch("estimator.fit.tune.blind", side_effect=KeyboardInterrupt)
    with interrupt:
        status, _, err = run("tune", ROD / "steps.csv", "-o", tmp_path / "tuned.toml")
    assert status == 130
    assert err.splitlines()[-1] == "stopped by Ctrl-C"
    assert not (tmp_path / "tuned.toml").exists()
