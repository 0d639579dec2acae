"""Models beside each other: the right errors in the right places."""

import json
from dataclasses import replace

import numpy as np
import pytest

from estimator.accuracy.compare import compare
from estimator.accuracy.horizon import horizons
from estimator.batch.trial import Trial
from estimator.work import Runs
from tests.conftest import PAPER, ballscrew, ended

TRUE = {"anchor_friction.power": 24.0}


@pytest.fixture(scope="module")
def lived(rig, full, driven, live):
    """25 minutes: rest, a drive, and more than ten minutes of rest."""
    return live(full.with_values(TRUE), rig, driven(rig, 1500, (20, 600)), seed=3).recording


@pytest.fixture(scope="module")
def both(rig, full, lived):
    known = replace(full.with_values(TRUE), about={"fitted_on": {"lived": lived.fingerprint}})
    other = replace(lived, channels=lived.channels + 0.0, time_s=lived.time_s + 0.5)
    return compare(known, Runs(rig, [lived, other])), compare(full, Runs(rig, [lived]))


def test_the_true_model_is_at_the_floor_and_the_other_is_warm_where_it_is_wrong(both):
    true, off = both
    assert true.whole["open_loop"].temperature_K < 1.3 * true.floor.temperature_K
    assert off.whole["open_loop"].temperature_K > 3 * off.floor.temperature_K
    worst = max(off.by_channel, key=lambda name: off.by_channel[name]["open_loop"] * (name != "displacement"))
    assert worst == "T12"  # under the anchor bearing


def test_only_the_other_model_is_warned_of(both):
    true, off = both
    assert not true.warnings
    assert "the readings hide what it does not explain" in off.warnings[0]


def test_held_out_is_what_the_model_was_not_fitted_to(both, rig, full, lived):
    true, off = both
    assert off.held_out is None  # a model that was never fitted has nothing held out
    assert true.held_out is not None
    alone = compare(full.with_values(TRUE), Runs(rig, [lived]))
    assert true.held_out["open_loop"].temperature_K == pytest.approx(alone.whole["open_loop"].temperature_K, rel=1e-3)


def test_parts_add_up_to_the_whole(both):
    _, off = both
    squares = [e["open_loop"].temperature_K for e in off.by_phase.values()]
    assert min(squares) < off.whole["open_loop"].temperature_K < max(squares)
    (by_speed,) = off.by_speed.values()
    assert by_speed["open_loop"].temperature_K >= off.whole["open_loop"].temperature_K


def test_elongation_is_compared_with_the_truth_where_it_is_known(rig, full, lived):
    known = compare(full.with_values(TRUE), Runs(rig, [lived]), truths=[np.full(len(lived), 7.0)])
    run = horizons(Trial(full.with_values(TRUE), rig, lived), full.with_values(TRUE))
    expected = np.sqrt(np.mean((7.0 - run.elongation["open_loop"]) ** 2))
    assert known.whole["open_loop"].elongation_um == pytest.approx(expected)
    assert (known.truths, known.recordings) == (1, 1)


def test_the_command_says_what_it_compared_with(fs20_log, tmp_path):
    with_truth = ballscrew("compare", fs20_log, "--rig", PAPER)[1]
    assert "elongation compared with the truth" in with_truth
    copy = tmp_path / fs20_log.name
    copy.write_bytes(fs20_log.read_bytes())
    out, _ = ended(0, "compare", copy, fs20_log, "--rig", PAPER)
    assert "with the truth; the displacement readings" in out
    assert "(1 of 2 recordings)" in out
    told = json.loads(ballscrew("compare", copy, "--json", "--quiet", "--rig", PAPER)[1])
    (model,) = told["models"]
    assert model["reference"] == {"truth": 0, "readings": 1}
    assert 0.0 < model["by_phase"]["early_stop"]["open_loop"]["elongation_um"] < 1.0  # from the direct reading
    copy.with_suffix(".truth.csv").write_text("nonsense\n")
    out, said = ended(1, "compare", copy, "--rig", PAPER)
    assert "truth.csv" in said
    assert "compared with the displacement readings" in out


def test_the_command_puts_models_side_by_side(fs20_log):
    out, _ = ended(0, "compare", fs20_log, "--model", PAPER / "model.toml", "--model", PAPER / "model.toml")
    assert "model alone (open loop)" in out
    assert "driving" in out
    told = json.loads(ballscrew("compare", fs20_log, "--json", "-", "--rig", PAPER)[1])
    (model,) = told["models"]
    assert {"name", "one_step", "ahead_10min", "open_loop", "held_out", "by_channel", "by_phase", "warnings"} <= set(
        model
    )
    assert set(model["by_phase"]) == {"drive", "early_stop", "late_stop"}
    assert 0 < model["one_step"]["temperature_K"] < 0.1
