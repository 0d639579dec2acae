"""What misfits weigh in a fit: what lasts as a block, what is quick by its own scatter, bodies by their thermometer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.open_loop import open_loop_misfit
from estimator.fit.misfits import MEMORY_S, Misfits, _quick
from estimator.fit.open_loop_fit import follow
from estimator.work import Runs

TAU, POWER = "thermometers.tau", "nut_friction.power"


@pytest.fixture(scope="module")
def lived(rig, full, driven, live):
    return live(full.with_values({TAU: 6.5}), rig, driven(rig, 600, (20, 400)), seed=4).recording


@pytest.fixture(scope="module")
def misfits(rig, full, lived):
    return Misfits(full, Runs(rig, [lived, replace(lived, name="again")]))


def test_slopes_are_those_of_the_misfits(misfits, full):
    for path in (TAU, POWER, "displacement.probe", "nut_body.g"):
        step = 1e-4 * abs(full[path])
        there, back = (misfits.of(full.with_values({path: full[path] + d})) for d in (step, -step))
        for far, near, slope in zip(there, back, misfits.slopes(full, [path]), strict=True):
            np.testing.assert_allclose(slope[:, 0], (far - near) / (2 * step), rtol=1e-4, atol=1e-6)


def test_what_is_quick_is_what_a_mean_of_older_misfits_leaves(misfits, full):
    """Written out for one thermometer with gaps, tick by tick."""
    trial = misfits.trials[0]
    off, tick_s = open_loop_misfit(trial, trial.pose(full)), trial.rig.tick_s
    off[10:30, 3] = np.nan
    values, left = off[:, 3], _quick(off, trial)[:, 3]
    for k in (0, 5, 40, len(values) - 1):
        known = [i for i in range(k + 1) if np.isfinite(values[i])]
        weight = np.exp(-(k - np.array(known)) * tick_s / MEMORY_S)
        assert left[k] == pytest.approx(values[k] - np.average(values[known], weights=weight), abs=1e-12)
    assert np.isnan(left[10:30]).all()


def test_quick_misfits_are_weighed_by_their_scatter(rig, full, lived, misfits):
    """All thermometers together count as one reading in two minutes; so does the displacement, where it was read."""
    lasting, others = misfits.of(full)
    quick = others[: len(lasting)]
    tick_s, heat = misfits.trials[0].rig.tick_s, misfits.trials[0].rig.is_thermometer
    rows = [np.nonzero(np.isfinite(open_loop_misfit(t, t.pose(full))))[1] for t in misfits.trials]
    of_heat = heat[np.concatenate(rows)]
    for some, channels in ((of_heat, heat.sum()), (~of_heat, 1)):
        assert (quick[some] ** 2).sum() == pytest.approx(some.sum() / channels * tick_s / MEMORY_S)
    assert misfits.weigh(full) == pytest.approx(0.0, abs=1e-12)


def test_a_lag_is_known_from_how_a_drive_begins_though_the_power_is_another(rig, full, lived):
    """An error that lasts weighs as one reading in ten minutes: by that alone a lag would be known to some seconds."""
    runs, off = Runs(rig, [lived]), full.with_values({POWER: 1.03 * full[POWER]})
    found = follow(off, runs, [TAU])
    assert found.model[TAU] == pytest.approx(6.5, abs=0.5)
    lasting, others = (rows[:, 0] @ rows[:, 0] for rows in Misfits(found.model, runs).slopes(found.model, [TAU]))
    assert others > 5.0 * lasting
