"""After the fact: the smoother beside the filter."""

import numpy as np
import pytest

from estimator.batch.replay import Replay
from estimator.faults.judge import TOGETHER_TICKS
from tests.estimator.batch.conftest import SPIKE_K, copy


def test_after_the_fact_the_estimate_is_as_sure_as_live_or_surer_and_the_same_at_the_end(anywhere):
    model, rig, run = anywhere
    found = Replay(model, rig, run, None, lambda _: None)
    smoothed, track = found.smoothed(), found.track
    assert smoothed.elongation_um[-1] == pytest.approx(track.elongation_um[-1], abs=1e-9)
    assert smoothed.sigma_um[-1] == pytest.approx(track.sigma_um[-1], abs=1e-9)
    assert (smoothed.sigma_um <= track.sigma_um + 1e-9).all()
    assert (smoothed.sigma_um[10:] / track.sigma_um[10:]).min() < 0.95
    assert abs(smoothed.elongation_um - track.elongation_um)[1:-1].max() > 1e-3


def test_what_the_gate_refused_is_not_smoothed_either(lived):
    model, rig, run = lived
    spiked, hole = copy(run), copy(run)
    spiked.channels[50, 2] += SPIKE_K
    hole.channels[50, 2] = np.nan
    a, b = (Replay(model, rig, log, None, lambda _: None).smoothed() for log in (spiked, hole))
    np.testing.assert_allclose(a.elongation_um, b.elongation_um, rtol=0, atol=1e-9)


def test_a_run_that_begins_anew_with_the_last_tick_has_nothing_to_smooth(lived):
    model, rig, run = lived
    run = copy(run)
    run.channels[:12, rig.is_thermometer] += SPIKE_K
    replayed = Replay(model, rig, run.rows(slice(0, 12 + TOGETHER_TICKS)), None, lambda _: None)
    assert (len(replayed.track), replayed.trial) == (12 + TOGETHER_TICKS, None)
    assert np.isnan(replayed.smoothed().elongation_um).all()
