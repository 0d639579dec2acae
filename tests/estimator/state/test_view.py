"""The error at the table: of a screw that both bearings hold, against what the virtual rig's springs do; with a bed."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.logs.truth import read_truth
from drivers.recordings import read_recording
from drivers.virtual_rig import simulate, write
from drivers.virtual_rig.machine.screw import ANCHOR_N_UM, FREE_N_UM
from estimator.batch.replay import Replay
from estimator.effects.held import HeldEnds
from estimator.filter import Filter
from estimator.screw import Bed
from estimator.state.view import UNSEEN_K_PER_H
from tests.conftest import stepped

STIFFNESSES = ("held_ends.k_anchor", "held_ends.k_free")
TABLE_MM = (0.0, 150.0, 300.0, 400.0)


@pytest.fixture(scope="module")
def held(paper, tmp_path_factory):
    """A drive of some minutes and a part of the stop after it, as recorded, with its truth; and the model for it."""
    log = tmp_path_factory.mktemp("held") / "FS-20.log"
    write(simulate("FS-20", plant={"held_ends": 1.0}, max_drive_s=300.0, cycles=1, seconds=420.0), log)
    rig, model = paper
    true = dict(zip(STIFFNESSES, (ANCHOR_N_UM, FREE_N_UM), strict=True))
    return read_recording(log, rig), read_truth(log), model, (model + HeldEnds).with_values(true)


def replayed(rig, model, recording) -> Replay:
    return Replay(model, rig, recording, None, lambda _: None, TABLE_MM)


def test_elongation_and_table_are_right_where_the_stiffnesses_are(rig, held):
    recording, truth, free, model = held
    right, wrong = (replayed(rig, each, recording) for each in (model, free))
    true_um = truth.at(recording.time_s)
    assert 20.0 < np.nanmax(true_um) < 40.0  # about half of what a screw that grows freely does
    assert np.nanmax(abs(right.track.open_loop_um - true_um)) < 0.5
    assert np.nanmax(abs(wrong.track.open_loop_um - true_um)) > 20.0
    table_um = truth.at_table(np.array(TABLE_MM), recording.time_s)
    assert np.nanmax(table_um) > 5.0
    assert np.nanmax(abs(right.table.error_um - table_um)) < 0.5


def test_what_is_not_known_of_the_stiffnesses_is_doubt_at_the_table(rig, held):
    recording, _, _, model = held
    vague = model.known(STIFFNESSES, np.diag([300.0, 300.0]) ** 2)
    known, doubted = (replayed(rig, each, recording).table.sd_um[-1] for each in (model, vague))
    stiffer = [model.with_values({path: model[path] + 300.0}) for path in STIFFNESSES]
    usual, *others = (replayed(rig, each, recording).table.error_um[-1] for each in (model, *stiffer))
    moved = np.linalg.norm([other - usual for other in others], axis=0)
    np.testing.assert_allclose(np.sqrt(doubted**2 - known**2), moved, rtol=0.15)  # what readings then move adds apart
    assert moved.min() > 1.0


def test_stiffnesses_whose_sum_of_compliances_is_known_leave_less_doubt_of_the_middle(rig, held):
    recording, _, _, model = held
    sd, rho = np.array([300.0, 180.0]), -0.97
    apart, together = (
        replayed(rig, model.known(STIFFNESSES, np.array([[1.0, r], [r, 1.0]]) * np.outer(sd, sd)), recording)
        for r in (0.0, rho)
    )
    assert together.track.sigma_um[-1] < 0.6 * apart.track.sigma_um[-1]


def test_the_bed_s_own_growth_comes_off_the_error_at_the_table_live_as_in_review(rig, shipped, fs20_log):
    told = replace(rig, bed=Bed("base", expansion=11e-6, tolerance=0.1))
    recording = read_recording(fs20_log, rig)
    warms = 22.0 + 0.01 * np.arange(len(recording))
    warms[200:205] = np.nan
    recording = replace(recording, inputs={**recording.inputs, "base": warms}).rows(slice(0, 220))
    usual, less = (replayed(each, shipped, recording) for each in (rig, told))
    live = stepped(Filter(shipped, told), recording)
    rise_K = 0.01 * np.arange(220)
    rise_K[200:205] = rise_K[199]  # what it showed last
    first = int(np.flatnonzero(np.isfinite(usual.table.error_um[:, 0]))[0])
    reach_m = (889.0 - (673.5 - np.array(TABLE_MM))) * 1e-3
    bed_um = 11.0 * (rise_K - rise_K[first])[:, None] * reach_m
    np.testing.assert_allclose((usual.table.error_um - less.table.error_um)[first:], bed_um[first:], atol=1e-9)
    own = np.sqrt(less.table.sd_um**2 - usual.table.sd_um**2)
    silent_h = np.where((np.arange(220) >= 200) & (np.arange(220) < 205), np.arange(220) - 199.0, 0.0) / 3600.0
    unseen_um = 11.0 * UNSEEN_K_PER_H * silent_h[:, None] * reach_m
    np.testing.assert_allclose(own[first:], np.hypot(0.1 * bed_um, unseen_um)[first:], atol=1e-6)
    np.testing.assert_allclose(live.error_at_table_um, less.track.error_at_table_um, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(live.error_at_table_sd_um, less.track.error_at_table_sd_um, rtol=1e-9, atol=1e-9)


def test_a_bed_whose_thermometer_was_never_read_leaves_the_table_unknown(rig, shipped, fs20_log):
    recording = read_recording(fs20_log, rig).rows(slice(0, 60))
    silent = replace(recording, inputs={**recording.inputs, "base": np.full(60, np.nan)})
    track = replayed(replace(rig, bed=Bed("base")), shipped, silent).track
    assert np.isnan(track.error_at_table_um).all()
    assert np.isfinite(track.elongation_um[-1])
