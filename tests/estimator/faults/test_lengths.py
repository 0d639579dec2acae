"""A length that grows as no screw does beside its thermometers: left out, named, and what it taught is forgotten."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from estimator.alarms.alarms import Alarms
from estimator.batch.replay import Replay, replay
from estimator.batch.trial import Trial
from estimator.faults.fault import Fault
from estimator.faults.sentences import sentences
from estimator.faults.use import Told, use_of
from estimator.filter import Filter
from estimator.step import SERIES
from tests.conftest import stepped

SECONDS, AT, ONE = 420, 120, 15


@pytest.fixture(scope="module")
def healthy(strokes):
    return strokes(SECONDS)


@pytest.fixture(scope="module")
def stuck(healthy):
    """The displacement reads the same from AT on."""
    readings = healthy.channels.copy()
    readings[AT:, ONE] = np.where(np.isfinite(readings[AT:, ONE]), np.nanmean(readings[AT - 10 : AT, ONE]), np.nan)
    return replace(healthy, channels=readings)


@pytest.fixture(scope="module")
def found(stuck, paper):
    return Replay(paper[1], paper[0], stuck, None, lambda _: None)


def test_it_is_left_out_within_a_minute_and_a_half_and_forgotten(stuck, found, paper):
    rig, model = paper
    track, without = found.track, replay(model, rig, stuck, lambda t: (np.arange(len(rig.names)) == ONE) & (t >= AT))
    parted = np.flatnonzero(track.fault[:, ONE] == Fault.APART)
    added = abs(track.elongation_um - without.elongation_um)
    assert AT < parted[0] < AT + 90
    assert added[parted[0] + 90 :].max() < 0.3 < added.max()  # what it did to the profile between thermometers fades
    assert not track.fused[parted[0] :, ONE].any()
    assert not np.delete(track.fault, ONE, axis=1).any()


def test_live_leaves_it_out_as_batch_does(stuck, found, paper):
    live = stepped(Filter(paper[1], paper[0]), stuck)
    for key in SERIES:
        np.testing.assert_allclose(getattr(live, key), getattr(found.track, key), rtol=1e-9, atol=1e-9, err_msg=key)


def test_after_the_fact_it_is_not_heard_at_all(healthy, found, paper):
    usual = Replay(paper[1], paper[0], healthy, None, lambda _: None).smoothed()
    assert abs(found.smoothed().elongation_um - usual.elongation_um)[1:].max() < 0.3


def test_a_healthy_one_of_another_screw_is_heard(healthy, paper):
    """Two per cent are within what steel does on another machine, and within seven sd of a fit."""
    readings = healthy.channels.copy()
    readings[:, ONE] *= 1.02
    assert not replay(paper[1], paper[0], replace(healthy, channels=readings)).fault.any()


def test_it_is_said_with_what_else_may_be_wrong_and_a_fit_hears_it(stuck, found, paper):
    rig, model = paper
    alarms = Alarms(rig)
    begun = [alarm.text for k in range(len(stuck)) for alarm in alarms.step(found.track.step(k, ("",) * 16))[0]]
    assert "displacement grows otherwise than the thermometers say" in begun
    told = sentences([use_of(stuck, rig, Told.by(found.track))], rig)
    assert any("left out, check that sensor; if it is well, the model's expansion is wrong" in each for each in told)
    assert not Trial(model, rig, stuck).muted[:, ONE].any()
