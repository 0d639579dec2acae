"""Whether a model is adequate, and what a failure is called: heat, a reading, or nothing."""

import json
from dataclasses import replace

import numpy as np
import pytest

from estimator.accuracy.noise_floor import Error
from estimator.batch.coarse import coarse
from estimator.effect import Effect, Param
from estimator.inputs.follower import ALWAYS, known_followers
from estimator.inputs.phase import PHASES
from estimator.missing_heat.diagnose import diagnose
from estimator.missing_heat.follows import Follows
from estimator.missing_heat.sentences import NOTHING, sentences
from estimator.missing_heat.where import Deficit
from estimator.missing_heat.wrong_reading import Wrong
from estimator.rig import Signal
from estimator.terms import SCREW, Heat
from estimator.work import Runs
from tests.conftest import FAST, ended

TICK_S = 15
SPEEDS = (1.0, 0.5, 0.25)


class Rub(Effect):
    """Something rubs between 50 and 100 mm, with the speed squared."""

    power = Param(4.0, "W", lo=0.0, hi=50.0)

    def terms(self, p, u, rig):
        yield Heat(SCREW, p.power * rig.screw.relative_speed(u.omega) ** 2, over=rig.screw.overlap(50.0, 100.0) / 5)


@pytest.fixture(scope="module")
def runs(small, driven):
    """Drives at three speeds, each with a long rest, and the rig with their tick."""
    fast = replace(small, inputs={**small.inputs, "speed": Signal(unit="rpm")})
    parts = [
        coarse(driven(fast, 5010, (600, 2100 + 300 * i), FAST * v, (0.0, 100.0)), fast, TICK_S)
        for i, v in enumerate(SPEEDS)
    ]
    return [run for run, _ in parts], parts[0][1]


@pytest.fixture(scope="module")
def lived(runs, live):
    def make(model):
        return [live(model, runs[1], run, seed=i).recording for i, run in enumerate(runs[0])]

    return make


def test_the_true_model_is_adequate(runs, lived, small_model):
    found = diagnose(small_model, Runs(runs[1], lived(small_model)))
    assert found.adequate
    assert found.where == ()
    assert found.readings == ()
    assert found.sentences == (NOTHING,)


def test_heat_is_named_with_its_place_phase_and_follower(runs, lived, small_model):
    stages = []
    found = diagnose(
        small_model, Runs(runs[1], lived(small_model + Rub), progress=lambda stage, share: stages.append(share))
    )
    assert not found.adequate
    assert found.readings == ()
    most = found.where[0]
    assert most.phase == "drive"
    assert most.from_mm <= 50.0
    assert most.to_mm >= 100.0
    spent = [each.blocks.seconds[each.blocks.phase == "drive"].sum() for each in found.maps]
    true = 4.0 * np.average(np.square(SPEEDS), weights=spent)
    assert most.heat_W == pytest.approx(true, abs=max(3 * most.sd_W, 0.1 * true))
    assert most.follows.name == "speed2"
    assert stages == sorted(stages)
    assert "while driving; that follows the speed squared" in found.sentences[1]


def test_an_error_of_the_displacement_alone_is_no_heat(runs, lived, small_model):
    recordings = lived(small_model)
    for each in recordings:
        each.channels[:, 4] += 1.5 * (each.channels[:, :4].mean(axis=1) - 22.0)
    found = diagnose(small_model, Runs(runs[1], recordings))
    assert not found.adequate
    assert found.where == ()
    assert [wrong.channel for wrong in found.readings] == ["displacement"]
    assert found.readings[0].unit == "um"


def test_one_thermometer_with_an_offset(runs, lived, small_model):
    recordings = lived(small_model)
    for each in recordings:
        each.channels[each.time_s > 600, 2] -= 0.4
    found = diagnose(small_model, Runs(runs[1], recordings))
    assert found.where == ()
    (wrong,) = found.readings
    assert wrong.channel == "T3"
    assert wrong.offset == pytest.approx(-0.4, abs=max(3 * wrong.sd, 0.02))
    assert found.sentences[-1] == "T3 reads 0.40 K low from the first motion on."


def test_sentences_put_what_matters_most_first(rig):
    chance = Follows(None, 0.4, 0.1)
    heat = [Deficit(100.0, 200.0, None, phase, 5.0, 0.5, 4.0, Follows(ALWAYS, 0.0, 1.0)) for phase in PHASES] + [
        Deficit(None, None, "cup", "late_stop", -2.0, 0.1, 1.0, chance)
    ]
    wrong = [Wrong("T1", "K", 0.1, 0.01, 0.2, 6.0, Follows(known_followers(rig)["board"], 0.001, 0.9))]
    told = sentences(False, Error(0.4, float("nan")), Error(0.05, float("nan")), heat, wrong)
    assert told == (
        "The model alone is 0.4 K off, 8 times what the sensors leave.",
        "T1 reads 0.2 K (rms) wrong; that follows the input 'board' (p < 0.002).",
        "It lacks 5 W +- 0.5 between 100 and 200 mm all the time.",
    )
    alone = sentences(False, Error(0.4, 1.0), Error(0.05, 0.1), heat[-1:], [])
    assert alone[1] == "It has too much: 2 W +- 0.1 in cup at rest."
    assert "nor a single reading" in sentences(False, Error(0.4, 1.0), Error(0.05, 0.1), [], [])[1]


def test_the_command_prints_tables_and_writes_json(fs20_log, tmp_path):
    out, _ = ended(0, "diagnose", fs20_log, "--json", tmp_path / "told.json")
    assert "model alone (open loop)" in out
    assert "sensors alone" in out
    told = json.loads((tmp_path / "told.json").read_text())
    assert {"adequate", "where", "readings", "sentences", "errors", "whiteness", "missing_heat"} <= set(told)
    for each in told["where"]:
        assert {"from_mm", "to_mm", "phase", "heat_W", "sd_W", "follows", "p"} <= set(each)
        assert each["phase"] in PHASES
    for each in told["readings"]:
        assert {"channel", "offset", "sd", "unit", "follows", "p"} <= set(each)
    (heat,) = told["missing_heat"].values()
    assert np.shape(heat["heat_W_m"]) == (len(heat["blocks"]), len(heat["zones"]))
