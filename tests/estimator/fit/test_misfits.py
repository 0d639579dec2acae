"""What misfits weigh in a fit: what lasts as a block, what is quick by its own scatter, bodies by their thermometer."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.recordings import read_recording
from estimator.batch.open_loop import open_loop_misfit
from estimator.batch.trial import BLOCK_S
from estimator.batch.trials import slow_trial
from estimator.fit.misfits import MEMORY_S, Misfits, _quick
from estimator.fit.open_loop_fit import follow
from estimator.hypotheses.moments import moments_of
from estimator.inputs.start import Start
from estimator.network.forcing import Forcing
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.sensitivity.objective import weights
from estimator.work import Runs
from tests.conftest import TWO

TAU, POWER = "thermometers.tau", "nut_friction.power"


@pytest.fixture(scope="module")
def lived(rig, full, driven, live):
    return live(full.with_values({TAU: 6.5}), rig, driven(rig, 600, (20, 400)), seed=4).recording


@pytest.fixture(scope="module")
def misfits(rig, full, lived):
    return Misfits(full, Runs(rig, [lived, replace(lived, name="again")]))


def test_slopes_are_those_of_the_misfits(misfits, full):
    """Half the slope of f'f is f'J, and of a sum of squares of nearly linear misfits half the curvature J'J."""
    paths = (TAU, POWER, "displacement.probe", "nut_body.g")
    here = misfits.weighed(misfits.at(full, paths))
    for k, path in enumerate(paths, start=1):
        step = 1e-3 * abs(full[path])
        there, back = (misfits.weighed(misfits.at(full.with_values({path: full[path] + d}))) for d in (step, -step))
        for far, near, products in zip(there, back, here, strict=True):
            of_square = (far[0, 0] - near[0, 0]) / (2 * step)
            assert of_square == pytest.approx(2 * products[0, k], rel=1e-3, abs=1e-3 * np.sqrt(products[k, k]))
            curvature = (far[0, 0] - 2 * products[0, 0] + near[0, 0]) / step**2
            assert curvature == pytest.approx(2 * products[k, k], rel=0.05, abs=1e-6), path


def test_misfits_stay_alike_as_long_as_the_rig_remembers(full, misfits):
    """Two bodies that forget in C / g s, and in how little heat each misses; the paper's rig, which takes longer than
    a drive does."""
    rig = load_rig(TWO)
    model = load_model(TWO / "model.toml")
    trial = slow_trial(model, rig, read_recording(TWO / "both.csv", rig))
    assert trial.block_s == pytest.approx(model["bodies.capacity"] / model["loss_to_air.g"])
    assert weights(rig, trial.block_s) == pytest.approx(rig.tick_s / trial.block_s)
    assert moments_of(trial, model, []).weight == pytest.approx(2.0 * np.ptp(trial.rest.time_s) / trial.block_s)
    assert misfits.trials[0].block_s == BLOCK_S < Forcing(full, misfits.trials[0].rig, Start(22.0, 0.0, {})).memory_s


def test_what_is_quick_is_what_a_mean_of_older_misfits_leaves(misfits, full):
    """Written out for one thermometer with gaps, tick by tick."""
    trial = misfits.trials[0]
    off, tick_s = open_loop_misfit(trial, trial.pose(full)), trial.rig.tick_s
    off[10:30, 3] = np.nan
    values, left = off[:, 3], _quick(off[None], trial)[0, :, 3]
    for k in (0, 5, 40, len(values) - 1):
        known = [i for i in range(k + 1) if np.isfinite(values[i])]
        weight = np.exp(-(k - np.array(known)) * tick_s / MEMORY_S)
        assert left[k] == pytest.approx(values[k] - np.average(values[known], weights=weight), abs=1e-12)
    assert np.isnan(left[10:30]).all()


def test_quick_misfits_are_weighed_by_their_scatter(full, misfits):
    """All thermometers together count as one reading in two minutes; so does the displacement, where it was read."""
    found, (_, others) = misfits.at(full), misfits.weighed(misfits.at(full))
    tick_s, heat = misfits.trials[0].rig.tick_s, misfits.trials[0].rig.is_thermometer
    count = sum(np.isfinite(open_loop_misfit(t, t.pose(full))).sum(axis=0) for t in misfits.trials)
    quick = others[0, 0] - misfits._lumps.products(found.bodies, found.along)[0, 0]
    assert quick == pytest.approx((count[heat].mean() + count[~heat].sum()) * tick_s / MEMORY_S)
    assert misfits.weigh(found) == pytest.approx(0.0, abs=1e-12)


def test_a_lag_is_known_from_how_a_drive_begins_though_the_power_is_another(rig, full, lived):
    """An error that lasts weighs as one reading in ten minutes: by that alone a lag would be known to some seconds."""
    runs, off = Runs(rig, [lived]), full.with_values({POWER: 1.03 * full[POWER]})
    found = follow(off, runs, [TAU])
    assert found.model[TAU] == pytest.approx(6.5, abs=0.5)
    misfits = Misfits(found.model, runs)
    lasting, others = misfits.weighed(misfits.at(found.model, [TAU]))
    assert others[1, 1] > 5.0 * lasting[1, 1]
