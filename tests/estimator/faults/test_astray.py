"""While the position is wrong, and heat with it, no channel that is well is accused."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.replay import replay
from estimator.faults.travel import Travel
from estimator.filter import Filter
from estimator.step import SERIES
from tests.conftest import stepped

SECONDS, AT, ONE = 420, 100, 5


@pytest.fixture(scope="module")
def frozen(strokes):
    """The position stands still from AT on, with the nut at one end."""
    run = strokes(SECONDS)
    at = AT + int(np.argmin(run.inputs["position"][AT : AT + 20]))
    later = np.arange(SECONDS + 1)[: len(run)] >= AT
    position = np.where(later, run.inputs["position"][at], run.inputs["position"])
    there = replace(run, inputs={**run.inputs, "position": position})
    coverage, stay = (np.where(later[:, None], cover[at], cover) for cover in (run.coverage, run.stay))
    return replace(there, coverage=coverage, stay=stay)


@pytest.fixture(scope="module")
def track(frozen, paper):
    return replay(paper[1], paper[0], frozen)


def test_nobody_is_accused_or_suspected(frozen, track, paper, monkeypatch):
    assert not track.fault.any()
    assert not track.may_drift_K.any()
    monkeypatch.setattr(Travel, "astray", False)
    blind = replay(paper[1], paper[0], frozen)
    assert blind.may_drift_K.any()


def test_live_judges_as_batch(frozen, track, paper):
    live = stepped(Filter(paper[1], paper[0]), frozen.rows(slice(2 * AT)))
    for key in SERIES:
        np.testing.assert_allclose(getattr(live, key), getattr(track, key)[: 2 * AT], rtol=1e-9, atol=1e-9, err_msg=key)


def test_what_reads_as_none_does_is_left_out_all_the_same(frozen, paper):
    readings = frozen.channels.copy()
    readings[AT + 50 :, ONE] = 85.0
    fault = replay(paper[1], paper[0], replace(frozen, channels=readings)).fault
    assert (fault[AT + 75 :, ONE] > 1).all()
    assert not np.delete(fault, ONE, axis=1).any()
