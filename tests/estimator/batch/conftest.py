"""Recordings that a model has lived, and what a replay and the filter say of them."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.replay import replay
from estimator.filter import Filter
from estimator.model import Model
from estimator.record import Recording
from estimator.rig import Rig
from estimator.step import SERIES, Track
from tests.conftest import stepped

TICKS = 150
SPIKE_K = 30.0


def both(model, rig, recording, mute=None) -> Track:
    """The filter's track, after every field of the replay has been found equal to it."""
    slow, fast = stepped(Filter(model, rig, mute), recording), replay(model, rig, recording, mute)
    assert (fast.bodies, fast.names) == (slow.bodies, slow.names)
    np.testing.assert_array_equal(fast.x_mm, slow.x_mm)
    for key in SERIES:
        a, b = getattr(fast, key), getattr(slow, key)
        assert a.shape == b.shape, key
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9, err_msg=key)
    return slow


def lived_on(rig: Rig, model: Model, stroke_mm: float, driven, live) -> tuple[Model, Rig, Recording]:
    """A recording with noise: a drive and some rest, air and board that warm up."""
    spans = np.array([TICKS, 20, 90]) * rig.tick_s
    drive = driven(rig, spans[0], tuple(spans[1:]), stroke=(0.0, stroke_mm))
    for name in ("ambient", "board"):
        drive.inputs[name][:] = 22 + np.linspace(0, 3, TICKS)
    return model, rig, live(model, rig, drive, seed=1, process=True).recording


@pytest.fixture(scope="module")
def lived(half, small_model, driven, live) -> tuple[Model, Rig, Recording]:
    """On the small rig at two ticks a second; the judge at one a second, on the paper's rig: faults/test_judge.py."""
    return lived_on(half, small_model, 100.0, driven, live)


@pytest.fixture(scope="module")
def on_the_papers_rig(rig, full, driven, live) -> tuple[Model, Rig, Recording]:
    return lived_on(rig, full, 400.0, driven, live)


@pytest.fixture(params=["lived", "on_the_papers_rig"])
def anywhere(request) -> tuple[Model, Rig, Recording]:
    return request.getfixturevalue(request.param)


def copy(run: Recording) -> Recording:
    """The recording with arrays of its own, to break."""
    own = {key: getattr(run, key).copy() for key in ("channels", "ages_s", "omega", "coverage")}
    return replace(run, inputs={name: column.copy() for name, column in run.inputs.items()}, **own)
