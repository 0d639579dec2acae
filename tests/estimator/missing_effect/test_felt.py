"""What reaches the table of what a model lacks: little while thermometers read, more while nothing is read."""

from dataclasses import replace

import pytest

from estimator.missing_effect.felt import felt
from estimator.rig import Signal
from estimator.work import Runs
from tests.estimator.conftest import with_effect

SECONDS = 1500


@pytest.fixture
def read_at_rest(bar):
    """The bar whose growth is read at rest too."""
    return replace(bar, inputs={**bar.inputs, "displacement_direct": Signal(unit="um")})


def test_a_wrong_model_is_felt_more_where_nothing_is_read(plain, read_at_rest, live, driven):
    rig, truth = read_at_rest, with_effect(plain, "churning", share=0.5)
    drives = [driven(rig, SECONDS, (20, 500), 174.5, (0, 100)), driven(rig, SECONDS, (20, 700), 87.0, (20, 80))]
    runs = Runs(rig, [live(truth, rig, drive, seed=k).recording for k, drive in enumerate(drives)])
    wrong, right = felt(plain, runs), felt(truth, runs)
    assert right.silent.rms_um < 0.25
    assert wrong.silent.rms_um > 1.5 * wrong.seen.rms_um
    assert wrong.silent.rms_um > 3 * right.silent.rms_um


def test_nothing_is_felt_where_no_length_is_read(plain, bar, lives):
    heat_only = replace(bar, channels={name: bar.channels[name] for name in bar.thermometers})
    assert felt(plain, Runs(heat_only, lives(plain)[:1])) is None
