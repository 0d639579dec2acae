"""The elongation from readings, joined at each stop by what the model alone leaves of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from estimator.accuracy.reference import left_alone
from estimator.accuracy.review import review
from estimator.batch.trial import Trial


@pytest.fixture(scope="module")
def lived(rig, full, driven, live):
    """A drive that grows by micrometres a minute, and rest; the direct reading's zero is another one."""
    run = live(full, rig, driven(rig, 400, (40, 250)), seed=8)
    measured, direct = run.recording.channels.copy(), np.full(400, np.nan)
    driving = run.recording.omega > 0
    measured[~driving, rig.index("displacement")] = np.nan
    direct[~driving] = run.elongation_um[~driving] - 40.0 * (run.recording.time_s[~driving] > 100)
    inputs = {**run.recording.inputs, "displacement_direct": direct}
    return replace(run, recording=replace(run.recording, channels=measured, inputs=inputs))


def test_the_reference_is_the_growth_whatever_the_zeros(lived, rig, full):
    found = review(lived.recording, rig, full)
    off = found.reference - lived.elongation_um
    read = np.isfinite(off)
    assert read[260:].all()
    assert abs(off[260:].mean()) < 2.0 * found.reference_sd[260:].mean()
    assert np.nanmax(np.abs(off)) < 1.0
    assert found.reference_sd[300] < 0.3


def test_the_model_that_joins_may_be_wrong(lived, rig, full):
    """It stands for half a minute around a stop, its growth for nothing."""
    weak = full.with_values({"nut_friction.power": 0.7 * full["nut_friction.power"]})
    off = review(lived.recording, rig, weak)
    assert abs(np.nanmean((off.reference - lived.elongation_um)[260:])) < 0.5
    assert abs(np.nanmean(off.errors["open_loop"][260:])) > 1.0


def test_what_a_reading_has_beside_growth_is_no_growth(lived, rig, full):
    """Without a model of the displacement its growth alone is taken off, by which the join comes out the same."""
    alone = Trial(full, rig, lived.recording).pose(full).run.grown
    left = left_alone(lived.recording, rig, full, np.append(0.0, alone))
    later = left_alone(lived.recording, rig, full, np.append(0.0, alone) + 7.0)
    np.testing.assert_allclose(left.um, later.um, atol=1e-9)
    assert np.isnan(
        left.um[np.isnan(lived.recording.inputs["displacement_direct"]) & ~(lived.recording.omega > 0)]
    ).all()
