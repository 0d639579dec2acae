"""What a fit hears of the nut's and the brackets' thermometers."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.trials import slow_trial
from estimator.fit.bodies import LUMP_K, LUMP_SHARE, Lumps, body_misfit, measured_bodies
from estimator.fit.open_loop_fit import follow
from estimator.work import Runs

CAPACITY, SHARE = "nut_body.capacity", "nut_friction.power_nut"


@pytest.fixture(scope="module")
def told(rig, full, driven, live):
    """told(share, zero): a recording whose nut thermometer shows so much of the nut's rise, with another zero."""
    drive = driven(rig, 1200, (20, 900))
    true = live(full.with_values({CAPACITY: 1200.0}), rig, drive, seed=8)
    model = slow_trial(full, rig, true.recording).pose(full)
    (state,) = [i for i, name in measured_bodies(model).items() if name == "nut"]
    scatter = 0.02 * np.random.default_rng(1).standard_normal(len(drive))

    def recorded(share=1.0, zero=0.0):
        shown = 22.0 + zero + share * (true.states[:, state] - 22.0) + scatter
        return replace(true.recording, inputs={**true.recording.inputs, "nut": shown})

    return recorded


def test_a_nut_that_shows_how_it_warms_tells_how_much_heat_it_stores(rig, full, told):
    known = {}
    for name, recording in (
        ("shown", told()),
        ("unread", replace(told(), inputs={**told().inputs, "nut": np.full(1200, np.nan)})),
    ):
        found = follow(full, Runs(rig, [recording]), [CAPACITY, SHARE])
        known[name] = np.sqrt(np.diag(found.covariance))
    assert (known["shown"] < 0.8 * known["unread"]).all()


@pytest.mark.parametrize(("share", "zero"), [(0.9, 0.0), (1.0, -0.4)])
def test_neither_its_zero_nor_where_it_sits_misleads(share, zero, rig, full, told):
    found = follow(full, Runs(rig, [told(share, zero)]), [CAPACITY, SHARE])
    for path, true, sd in zip(found.paths, (1200.0, full[SHARE]), np.sqrt(np.diag(found.covariance)), strict=True):
        assert abs(found.model[path] - true) < 2.0 * sd, path


def test_one_that_is_stuck_or_jumps_says_nothing(rig, full, told):
    recording = told()
    nut = recording.inputs["nut"].copy()
    nut[300:600], nut[600:] = 85.0, nut[600]
    broken = replace(recording, inputs={**recording.inputs, "nut": nut})
    trial = slow_trial(full, rig, broken)
    posed = trial.pose(full)
    off = body_misfit(trial, posed)[:, list(measured_bodies(posed).values()).index("nut")]
    assert np.isfinite(off[:50]).all()
    assert np.nanmax(np.abs(off)) < 5.0
    assert np.isnan(off[-50:]).all()


def test_bodies_without_a_thermometer_are_not_heard(rig, full, told):
    bare = replace(rig, inputs={name: signal for name, signal in rig.inputs.items() if name != "nut"})
    recording = told()
    trial = slow_trial(full, bare, replace(recording, inputs={n: c for n, c in recording.inputs.items() if n != "nut"}))
    posed = trial.pose(full)
    assert "nut" not in measured_bodies(posed).values()
    assert body_misfit(trial, posed).shape == (len(trial.rest), len(measured_bodies(posed)))


def test_misfits_weigh_by_their_covariance_where_a_lump_shows_some_share_of_its_rise():
    """By the covariance written out."""
    draw = np.random.default_rng(2)
    shown, off, steps = 4.0 * draw.standard_normal((40, 2)), 0.3 * draw.standard_normal((40, 2)), 12.0
    shown[5, 0] = off[5, 0] = np.nan
    known = np.isfinite(off)
    count, squares, rises = known.sum(axis=0), np.nansum(off**2, axis=0), np.nansum(shown**2, axis=0)
    lumps = Lumps(count, squares, rises, steps)
    assert lumps.sd_K == pytest.approx(np.sqrt(squares / count))
    assert Lumps(count, 0.01 * squares, rises, steps).sd_K == pytest.approx(LUMP_K)
    products = lumps.products(np.diag(squares)[:, :, None] * np.eye(2), np.diag(np.nansum(shown * off, axis=0)))
    for i in range(2):
        r, v = shown[known[:, i], i], off[known[:, i], i]
        C = lumps.sd_K[i] ** 2 * steps * np.eye(len(r)) + LUMP_SHARE**2 * np.outer(r, r)
        assert products[i, i] == pytest.approx(v @ np.linalg.solve(C, v))
