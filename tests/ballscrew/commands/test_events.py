"""`ballscrew diagnose` tells what began within a run, in words and for programs."""

import json
from pathlib import Path

import pytest

from drivers.virtual_rig import simulate, write
from tests.conftest import PAPER, ballscrew

ONSET_S = 1000.0


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive and a rest in which 6 W come on at some place."""
    run = simulate("FS-20", seed=8, plant={"local_heat": 4.0}, onset_s=ONSET_S, cycles=1, seconds=1500.0)
    return Path(write(run, tmp_path_factory.mktemp("events") / "late.log"))


def test_an_event_is_told_with_clock_place_and_size(log):
    _, out, err = ballscrew("diagnose", log, "--rig", PAPER, "--model", PAPER / "base.toml", "--json")
    found = json.loads(out)["events"]
    first = found[0]
    assert first["run"] == "late.log"
    assert first["since_s"] == pytest.approx(ONSET_S, abs=600.0)
    assert first["kind"] == "heat"
    assert first["heat_W"] == pytest.approx(6.0, rel=0.4)
    place = simulate("FS-20", seed=8, plant={"local_heat": 4.0}, seconds=1.0).places["local_heat"]
    assert first["from_mm"] - 50.0 < place < first["to_mm"] + 50.0
    assert {"clock", "until_s", "sd_s", "channel", "sd_W"} <= set(first)
    assert f"from {first['clock'][11:16]} on ({first['since_s']:.0f} s" in first["sentence"]
    assert first["sentence"] in err
