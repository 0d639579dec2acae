"""The heat that repairs an open-loop run: found where, when and as large as it was, and honestly sure."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.coarse import coarse
from estimator.batch.trial import BLOCK_S
from estimator.batch.trials import slow_trial
from estimator.effect import Effect, Param
from estimator.missing_heat.blocks import blocks
from estimator.missing_heat.misfit import misfit
from estimator.missing_heat.missing_heat import ALL, missing_heat
from estimator.missing_heat.where import by_phase
from estimator.missing_heat.zones import zones
from estimator.model import model_of
from estimator.record import Recording
from estimator.rig import Channel, Rig
from estimator.terms import SCREW, Heat, Link, Read, Store

TICK_S = 15  # as long as open-loop runs take it
SECONDS = 7005
DRIVES = (600, 2400)


class Stove(Effect):
    """Heat into 100 - 150 mm of the screw while it turns."""

    power = Param(3.0, "W", lo=-50.0, hi=50.0)

    def terms(self, p, u, rig):
        yield Heat(SCREW, p.power * u.motion.turning, over=rig.screw.overlap(100.0, 150.0) / 5)


class Cup(Effect):
    """A cup that cools, and two thermometers in it."""

    power = Param(0.0, "W", lo=-50.0, hi=50.0)

    def terms(self, p, u, rig):
        yield Store("cup", 500.0, 0.01)
        yield Link("cup", "start", 0.5)
        yield Heat("cup", p.power * (u.motion.time_s > 2000.0))
        yield Read("A", {"cup": 1.0}, 0.02)
        yield Read("B", {"cup": 1.0}, 0.02)


@pytest.fixture(scope="module")
def drive(small, driven) -> tuple[Recording, Rig]:
    """A drive and a long rest at a long tick."""
    return coarse(driven(small, SECONDS, DRIVES, stroke=(0.0, 100.0)), small, TICK_S)


@pytest.fixture(scope="module")
def lived(drive, small_model, live):
    """lived(power, seed): a recording with so many W more than the model has."""
    run, rig = drive

    def make(power: float, seed: int, model=None) -> Recording:
        truth = (model or small_model) + Stove
        return live(truth.with_values({"stove.power": power}), rig, run, seed=seed).recording

    return make


def judged(model, rig, *recordings):
    return missing_heat([misfit(model, slow_trial(model, rig, recording)) for recording in recordings])


def test_blocks_share_the_ticks_out_and_none_is_long(drive):
    run, rig = drive
    found = blocks(run, rig.tick_s, BLOCK_S)
    assert found.seconds.sum() == len(run) * TICK_S
    assert found.seconds.max() <= BLOCK_S
    assert list(found.phase[:3]) == ["late_stop", "drive", "drive"]
    assert len({*zip(found.bin_of_tick.tolist(), found.of_tick.tolist(), strict=True)}) == len(found.ticks)
    assert found.mean(run.time_s) == pytest.approx(found.at_s)


def test_short_drives_and_stops_share_blocks(small, driven):
    run = driven(small, 1200, (0, 1200))
    often = replace(run, omega=np.where(run.time_s // 20 % 2 == 0, run.omega, 0.0))
    assert len(blocks(often, 1.0, BLOCK_S)) <= 5


def test_columns_are_what_heat_does(drive, small_model, lived):
    rig = drive[1]
    plain, heated = (misfit(small_model, slow_trial(small_model, rig, lived(power, seed=1))) for power in (0.0, 3.0))
    zone = next(i for i, z in enumerate(heated.zones) if z.from_mm == 100.0)
    put = np.zeros((len(heated.blocks), len(heated.zones)))
    put[heated.blocks.phase == "drive", zone] = 3.0 / 0.05
    off = heated.y - plain.y - heated.A @ put.ravel()
    thermometers = heated.channel < 4
    assert np.abs((heated.y - plain.y)[thermometers]).max() > 1.0
    assert np.abs(off[thermometers]).max() < 0.05  # the borders of phases are known to a coarse tick


def test_known_heat_is_found_at_its_place_and_time(drive, small_model, lived):
    rig = drive[1]
    found = judged(small_model, rig, lived(3.0, seed=2))
    mean, covariance = by_phase(found, "drive")
    assert int(np.argmax(mean)) == [zone.from_mm for zone in found[0].zones].index(100.0)
    assert abs(mean.sum() - 3.0) < 3 * np.sqrt(covariance.sum()) + 0.03
    rest, sd = by_phase(found, "late_stop")
    assert np.all(np.abs(rest) < 4 * np.sqrt(np.diag(sd)) + 0.02)


def test_its_sd_is_honest_over_seeds(drive, small_model, lived):
    scores = []
    for seed in range(8):
        mean, covariance = by_phase(judged(small_model, drive[1], lived(3.0, seed=seed)), "drive")
        scores.append((mean.sum() - 3.0) / np.sqrt(covariance.sum()))
    assert 0.1 < np.mean(np.square(scores)) < 2.5
    assert np.abs(scores).max() < 3.5


def test_one_wrong_thermometer_is_no_heat(drive, small_model, lived):
    run = lived(0.0, seed=3)
    run.channels[run.time_s > DRIVES[0], 1] += 0.3
    (found,) = judged(small_model, drive[1], run)
    mean, covariance = by_phase([found], "drive")
    assert np.all(np.abs(mean) < 3 * np.sqrt(np.diag(covariance)) + 0.05)
    late = found.readings["T2"].mean[-3:]
    assert late == pytest.approx(0.3, abs=0.05)
    assert np.abs(found.readings["T3"].mean).max() < 0.05
    assert np.abs(found.readings[ALL].mean).max() < 0.05


def test_a_sensor_that_the_filter_would_refuse_is_still_seen(drive, small_model, lived):
    run = lived(0.0, seed=3)
    run.channels[run.time_s > DRIVES[0], 1] += 5.0
    (found,) = judged(small_model, drive[1], run)
    assert found.readings["T2"].mean[-1] == pytest.approx(5.0, abs=0.3)


def test_a_spike_does_not_count(drive, small_model, lived):
    run = lived(0.0, seed=4)
    run.channels[233, 2] += 30.0
    assert not np.any(np.nan_to_num(misfit(small_model, slow_trial(small_model, drive[1], run)).open_loop[:, 2]) > 1.0)


def test_zones_of_a_rig_without_a_screw_are_its_bodies():
    rig = Rig("cup", 5.0, {"A": Channel(node="cup"), "B": Channel(node="cup")}, {})
    model = model_of([Cup], "cup")
    K, dice = 1200, np.random.default_rng(5)
    temperature, heated = np.zeros(K), np.arange(K) * 5.0 > 2000.0
    for k in range(1, K):
        temperature[k] = 4 * heated[k] + (temperature[k - 1] - 4 * heated[k]) * np.exp(-5.0 * 0.5 / 500.0)
    channels = 22 + temperature[:, None] + 0.02 * dice.standard_normal((K, 2))
    none = np.zeros((K, 2))
    run = Recording("cup", np.arange(1, K + 1) * 5.0, channels, none, {}, np.zeros(K), np.zeros((K, 0)))
    (found,) = judged(model, rig, run)
    assert [zone.node for zone in found.zones] == ["cup"]
    late = found.blocks.at_s > 2700
    assert found.mean[late, 0] == pytest.approx(2.0, abs=0.15)
    assert found.mean[found.blocks.at_s < 1500, 0] == pytest.approx(0.0, abs=0.15)


def test_zones_cover_the_screw(drive, small_model):
    rig = drive[1]
    run = replace(drive[0], channels=np.full_like(drive[0].channels, 22.0))
    posed = misfit(small_model, slow_trial(small_model, rig, run))
    places = zones(rig, posed.trial.pose(small_model).forcing.place)
    assert (places[0].from_mm, places[-1].to_mm) == (0.0, 200.0)
    assert sum(zone.length_m for zone in places) == pytest.approx(0.2)
