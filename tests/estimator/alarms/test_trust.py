"""Whether to rely on the estimate: a reason that comes and goes does not make it flicker."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.alarms.trust import FEW_S, STEADY_S, Watch
from estimator.record import Sample
from estimator.step import Mode
from tests.estimator.alarms.test_alarms import step_of


@pytest.fixture
def lived(small):
    """lived(times, diverged=..., used=...): by which ticks the estimate is to be relied on, and why not at the last."""

    def of(times, diverged=lambda t: False, used=lambda t: True):
        watch, valid = Watch(small), []
        for t in times:
            step = replace(step_of(small, t, np.zeros(len(small.names)), 1.0), time_s=float(t), mode=Mode.UPDATE)
            step = replace(step, fused=step.fused & used(t))
            inputs = dict.fromkeys(small.inputs, np.nan)
            sample = Sample(float(t), step.measured, 0 * step.measured, inputs, 0.0, np.empty(0))
            watch.drive(float(t))
            watch.tick(sample, step, diverged(t))
            trust = watch.trust(float(t))
            valid.append(trust.valid)
        return valid, trust.why

    return of


def test_the_first_estimate_may_be_relied_on_at_once(lived):
    assert lived(range(3)) == ([True] * 3, ())


def test_what_comes_and_goes_each_second_lasts_until_it_has_been_gone_for_some(lived):
    valid, _ = lived(range(30), diverged=lambda t: 5 <= t < 15 and t % 2)
    assert valid == [t < 5 or t >= 13 + STEADY_S for t in range(30)]


def test_while_it_lasts_the_reason_stays_the_last_one(lived):
    assert lived(range(12), diverged=lambda t: t == 10) == ([True] * 10 + [False] * 2, ("rig and model part",))


def test_without_thermometers_it_is_told_after_seconds_and_passes_likewise(lived):
    valid, _ = lived(range(40), used=lambda t: not 10 <= t < 20)
    assert valid == [t <= 9 + FEW_S or t >= 19 + STEADY_S for t in range(40)]
