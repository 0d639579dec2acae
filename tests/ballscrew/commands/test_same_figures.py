"""A figure has one value, whichever command prints it: of a recording whose truth is not known."""

import json
import shutil

import pytest

from tests.conftest import ballscrew as run


@pytest.fixture(scope="module")
def told(fs20_log, tmp_path_factory):
    """What review, compare and diagnose say in JSON of a drive and some of its cooldown."""
    log = tmp_path_factory.mktemp("unknown") / "run.log"
    shutil.copy(fs20_log, log)
    return {name: json.loads(run(name, log, "--json", "--quiet")[1]) for name in ("review", "compare", "diagnose")}


def test_the_model_alone_is_as_far_off_in_every_command(told):
    (reviewed,), (compared,) = told["review"]["recordings"], told["compare"]["models"]
    assert reviewed["temperature_K"]["open_loop"] == pytest.approx(compared["open_loop"]["temperature_K"], rel=1e-4)
    assert reviewed["open_loop"]["rms_um"] == pytest.approx(compared["open_loop"]["elongation_um"], rel=1e-4)
    assert told["diagnose"]["errors"]["open_loop"] == compared["open_loop"]


def test_so_is_what_is_predicted_and_the_floor(told):
    (reviewed,), (compared,) = told["review"]["recordings"], told["compare"]["models"]
    assert reviewed["temperature_K"]["one_step"] == pytest.approx(compared["one_step"]["temperature_K"], rel=1e-4)
    for horizon in ("one_step", "ahead_10min"):
        assert told["diagnose"]["errors"][horizon] == compared[horizon]
    assert told["diagnose"]["noise_floor"] == compared["noise_floor"]


def test_the_cooldown_is_in_it(told):
    (compared,) = told["compare"]["models"]
    assert compared["by_phase"]["early_stop"]["open_loop"]["elongation_um"] is not None


def test_the_verdict_is_the_same(told):
    assert told["review"]["machine"] == told["compare"]["models"][0]["machine"]
