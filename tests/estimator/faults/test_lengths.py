"""A length that grows as no screw does beside its thermometers: left out, named, and what it taught is forgotten."""

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


LIES = {
    "stuck": lambda reading, last: last,
    "a fifth too much": lambda reading, last: last + 1.2 * (reading - last),
    "the other way": lambda reading, last: 2.0 * last - reading,
}


def lying(healthy, kind):
    """The displacement lies from AT on."""
    readings = healthy.channels.copy()
    later = readings[AT:, ONE]
    readings[AT:, ONE] = np.where(
        np.isfinite(later), LIES[kind](later, np.nanmean(readings[AT - 10 : AT, ONE])), np.nan
    )
    return replace(healthy, channels=readings)


@pytest.fixture(scope="module")
def stuck(healthy):
    """The displacement reads the same from AT on."""
    return lying(healthy, "stuck")


@pytest.fixture(scope="module")
def found(stuck, paper):
    return Replay(paper[1], paper[0], stuck, None, lambda _: None)


@pytest.fixture(scope="module")
def usual(healthy, paper):
    return replay(paper[1], paper[0], healthy)


@pytest.mark.parametrize("kind", LIES)
def test_whatever_it_says_the_estimate_knows_how_far_it_may_have_been_led(kind, healthy, usual, paper):
    track = replay(paper[1], paper[0], lying(healthy, kind))
    off = abs(track.elongation_um - usual.elongation_um)
    assert off.max() > 0.5
    assert (off <= np.maximum(5 * track.sigma_um, 0.5)).all()
    parted = np.flatnonzero(track.fault[:, ONE] == Fault.APART)[0]
    assert off[parted:].max() < 0.3
    assert not np.delete(track.fault, ONE, axis=1).any()


def test_thermometers_that_no_longer_fit_the_model_accuse_no_length(stuck, rig, shipped):
    """They may be misled themselves, as by a position that is wrong."""
    shaken = stuck.channels.copy()
    shaken[AT - 60 :, :ONE] += 0.3 * np.random.default_rng(1).standard_normal(shaken[AT - 60 :, :ONE].shape)
    parted = replay(shipped, rig, replace(stuck, channels=shaken)).fault[: AT + 20, ONE] == Fault.APART
    assert not parted.any()


def test_it_is_left_out_within_seconds_and_forgotten(stuck, found, rig, shipped):
    track, without = found.track, replay(shipped, rig, stuck, lambda t: (np.arange(len(rig.names)) == ONE) & (t >= AT))
    parted = np.flatnonzero(track.fault[:, ONE] == Fault.APART)
    added = abs(track.elongation_um - without.elongation_um)
    assert AT < parted[0] < AT + 20
    assert added[parted[0] :].max() < 0.15 < added.max()
    assert not track.fused[parted[0] :, ONE].any()
    assert not np.delete(track.fault, ONE, axis=1).any()


def test_live_leaves_it_out_as_batch_does(stuck, found, paper):
    live = stepped(Filter(paper[1], paper[0]), stuck.rows(slice(AT + 60)))
    for key in SERIES:
        np.testing.assert_allclose(
            getattr(live, key), getattr(found.track, key)[: AT + 60], rtol=1e-9, atol=1e-9, err_msg=key
        )


def test_after_the_fact_it_is_not_heard_at_all(healthy, found, paper):
    usual = Replay(paper[1], paper[0], healthy, None, lambda _: None).smoothed()
    assert abs(found.smoothed().elongation_um - usual.elongation_um)[1:].max() < 0.3


def test_a_healthy_one_of_another_screw_is_heard(healthy, paper):
    """Two per cent are within what steel does on another machine, and within seven sd of a fit."""
    readings = healthy.channels.copy()
    readings[:, ONE] *= 1.02
    assert not replay(paper[1], paper[0], replace(healthy, channels=readings)).fault.any()


def test_it_is_said_with_what_else_may_be_wrong_and_a_fit_hears_it(stuck, found, rig, shipped):
    alarms = Alarms(rig)
    begun = [alarm.text for k in range(len(stuck)) for alarm in alarms.step(found.track.step(k, ("",) * 16))[0]]
    assert "displacement grows otherwise than the thermometers say" in begun
    told = sentences([use_of(stuck, rig, Told.by(found.track))], rig)
    assert any("left out, check that sensor; if it is well, the model's expansion is wrong" in each for each in told)
    assert not Trial(shipped, rig, stuck).muted[:, ONE].any()


def test_asked_for_judgements_alone_it_judges_as_with_all_that_an_estimate_is_in_doubt_by(stuck, paper, monkeypatch):
    """That is looked up once lengths have led far."""
    monkeypatch.setattr("estimator.batch.judged.LONGEST", AT // 2)
    trial = Trial(paper[1], paper[0], stuck, gated=False)
    posed = trial.pose(paper[1])
    closely, parts = (list(trial.filtered(posed, trial.doubt(posed), each)) for each in (True, False))
    for one, other in zip(closely, parts, strict=True):
        np.testing.assert_array_equal(one.judgement.fault, other.judgement.fault)
    assert (parts[-1].judgement.fault == Fault.APART).any()
    assert not parts[0].led.doubt.any()
    np.testing.assert_allclose(parts[-1].led.doubt, closely[-1].led.doubt, rtol=1e-9, atol=1e-12)
