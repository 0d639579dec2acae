"""Whether a run begins with a cold screw, and what it has grown already where it does not."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.logs.truth import read_truth
from drivers.recordings import read_recording
from estimator.state.gate import unmuted
from estimator.state.run import begin
from estimator.state.warmth import Warmth, warmth


@pytest.fixture(scope="module")
def recording(paper, fs20_log):
    return read_recording(fs20_log, paper[0])


def began(paper, recording, at: int = 0, **inputs: float) -> Warmth | None:
    """The warmth of a run that begins there, with inputs that show so much more."""
    rig, model = paper
    shown = {name: column + inputs.get(name, 0.0) for name, column in recording.inputs.items()}
    return warmth(begin(model, rig, replace(recording, inputs=shown).rows(slice(at, at + 1)), unmuted(rig)))


def test_a_cold_screw_is_not_warm_whatever_the_sensors_of_the_surroundings_are_off_by(paper, recording):
    for more in (0.0, 1.0, -1.0):
        found = began(paper, recording, ambient=more, base=-more)
        assert abs(found.grown_um) < found.sd_um
        assert not found.warm


@pytest.mark.parametrize("at", [150, 200, 250, 300, 400])
def test_a_warm_one_is_by_about_what_it_has_grown(paper, recording, fs20_log, at):
    """While it turns and after the stop."""
    found = began(paper, recording, at)
    true_um = read_truth(fs20_log).at(recording.time_s)[at]
    assert found.warm
    assert abs(found.grown_um - true_um) < 2 * found.sd_um
    assert 1.0 < found.sd_um < 4.0


def test_air_and_base_that_differ_tell_it_less_well(paper, recording):
    alike, apart = began(paper, recording, 300), began(paper, recording, 300, ambient=1.0, base=-1.0)
    growth = 935.5e-3 * 12.0  # um/K of the measured span
    assert apart.grown_um == pytest.approx(alike.grown_um, abs=1e-9)
    assert apart.sd_um**2 - alike.sd_um**2 == pytest.approx(growth**2, rel=0.15)


def test_without_surroundings_nothing_tells(paper, recording):
    gone = {name: np.full_like(column, np.nan) for name, column in recording.inputs.items()}
    assert began(paper, replace(recording, inputs=gone), 300) is None


def test_the_sentence_says_how_well_it_is_known_and_the_way_out():
    said = "began warm: about 28 um grown already, +- 5 (2 sd)"
    lacks = "; the elongation counts from there, unless rig.toml says zero_C"
    assert Warmth(28.4, 2.3, False).sentence == said + lacks
    assert Warmth(28.4, 2.3, True).sentence == said


def test_with_a_zero_it_is_counted(rig, shipped, recording):
    assert began((replace(rig, zero_C=20.0), shipped), recording, 300).counted
