"""Quality figures on readings whose statistics are known."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.accuracy.quality import ChannelQuality, quality
from estimator.batch.coarse import coarse
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.effect import Effect, Param
from estimator.model import Model, model_of
from estimator.record import Array, Recording
from estimator.rig import Channel, Rig
from estimator.terms import Read, Store

TICKS = 3000
SD = 0.1
RIG = Rig("two blocks", 1.0, {"A": Channel(node="a"), "B": Channel(node="b")}, {})


class Blocks(Effect):
    """Two blocks of no end of heat: dT/dt = 0."""

    noise = Param(1e-3, "W/sqrt(Hz)", lo=0.0, hi=1.0)

    def terms(self, p, u, rig):
        yield Store("a", 1e9, p.noise)
        yield Store("b", 1e9, p.noise)


class Thermocouples(Effect):
    """They scatter: y = T."""

    sd = Param(SD, "K", lo=0.0, hi=1.0)
    zero_sd = Param(0.0, "K", lo=0.0, hi=10.0)

    def terms(self, p, u, rig):
        yield Read("A", {"a": 1.0}, p.sd)
        yield Read("B", {"b": 1.0}, p.sd, zero_sd=p.zero_sd)


MODEL = model_of([Blocks, Thermocouples], "blocks")


def judged(*scatter: Array, model: Model = MODEL) -> tuple[ChannelQuality, ...]:
    """Quality of readings (K, 2) that are 22 degC and this scatter, after a first sample without any."""
    trials = []
    for noise in scatter:
        K = len(noise) + 1
        channels = 22 + np.vstack([np.zeros(2), noise])
        none = np.zeros((K, 2))
        run = Recording("blocks", np.arange(K) + 1.0, channels, none, {}, np.zeros(K), np.zeros((K, 0)))
        trials.append(Trial(model, RIG, run))
    return quality(Trials(trials), model)


def white(seed: int = 0, ticks: int = TICKS) -> Array:
    return np.random.default_rng(seed).standard_normal((ticks, 2))


def test_white_noise_of_the_size_it_should_have_is_honest():
    for found in judged(SD * white()):
        assert found.readings == TICKS
        assert found.nis == pytest.approx(1.0, abs=0.08)
        assert found.in_2sd == pytest.approx(0.954, abs=0.012)
        assert found.whiteness < 5 / np.sqrt(TICKS)


def test_noise_of_another_size_shows_in_its_own_channel():
    half, twice = judged(SD * white() * [0.5, 2.0])
    assert half.nis == pytest.approx(0.25, rel=0.1)
    assert twice.nis == pytest.approx(4.0, rel=0.1)
    assert half.in_2sd > 0.999
    assert twice.in_2sd == pytest.approx(0.683, abs=0.03)
    assert max(half.whiteness, twice.whiteness) < 5 / np.sqrt(TICKS)


def test_noise_with_a_memory_is_not_white():
    noise = SD * white(1)
    for k in range(1, TICKS):
        noise[k, 0] = 0.6 * noise[k - 1, 0] + 0.8 * noise[k, 0]
    noise[:, 1] += SD * np.sin(2 * np.pi * np.arange(TICKS) / 80)  # half a period is within a minute
    memory, swing = judged(noise)
    assert memory.whiteness == pytest.approx(0.6, abs=0.06)
    assert swing.whiteness == pytest.approx(1 / 3, abs=0.06)
    assert memory.nis == pytest.approx(1.0, abs=0.12)


def test_gaps_are_left_out_and_whiteness_is_that_of_the_pairs_there_are():
    noise = SD * white(2)
    for k in range(1, TICKS):
        noise[k] = 0.8 * noise[k - 1] + 0.6 * noise[k]
    noise[np.random.default_rng(0).random(TICKS) < 0.5, 0] = np.nan
    some, every = judged(noise)
    assert some.readings == np.isfinite(noise[:, 0]).sum()
    assert every.readings == TICKS
    assert some.whiteness == pytest.approx(0.8, abs=0.08)


def test_few_readings_say_nothing_of_whiteness_and_none_say_nothing_at_all():
    noise = SD * white()
    noise[90:, 0] = np.nan
    noise[:, 1] = np.nan
    few, none = judged(noise)
    assert np.isnan(few.whiteness)
    assert np.isfinite(few.nis)
    assert none.readings == 0
    assert np.isnan([none.nis, none.whiteness, none.in_2sd]).all()


def test_recordings_are_taken_together_and_the_least_white_one_is_named():
    noise = SD * white(3)
    for k in range(1, TICKS):
        noise[k] = 0.6 * noise[k - 1] + 0.8 * noise[k]
    both = judged(2 * SD * white(ticks=1000), noise)
    for found, alone in zip(both, judged(noise), strict=True):
        assert found.readings == TICKS + 1000
        assert found.whiteness == alone.whiteness
        assert found.nis == pytest.approx((4 * 1000 + alone.nis * TICKS) / (TICKS + 1000), rel=0.05)


def test_the_first_reading_of_a_channel_that_tells_its_own_zero_is_left_out():
    noise = SD * white()
    noise[:, 1] += 7.0
    noise[:100, 1] = np.nan
    model = MODEL.with_values({"thermocouples.zero_sd": 5.0})
    K = TICKS + 1
    channels = 22 + np.vstack([[0.0, np.nan], noise])
    run = Recording("b", np.arange(K) + 1.0, channels, np.zeros((K, 2)), {}, np.zeros(K), np.zeros((K, 0)))
    known, told = quality(Trials([Trial(model, RIG, run)]), model)
    assert known.readings == TICKS
    assert told.readings == TICKS - 100 - 1
    assert told.nis == pytest.approx(1.0, abs=0.08)


def test_blind_figures_are_of_what_is_read_after_ten_minutes():
    """Of steady blocks whose readings scatter three times as much in the last minute of each ten."""
    noise = SD * white(4, 12000)
    noise[np.arange(12000) % 600 >= 540] *= 3.0
    for found in judged(noise):
        assert found.nis == pytest.approx(0.9 + 0.1 * 9, rel=0.1)
        assert found.blind_nis == pytest.approx(9.0, rel=0.9)
        assert found.blind_nis > 3
        assert found.blind_in_2sd < 0.9 < found.in_2sd


def test_a_filter_is_honest_of_what_its_own_model_lived(small, small_model, driven, live):
    exact = replace(small, screw=replace(small.screw, expansion_tolerance=0.0))
    model = small_model.with_values({"thermometers.tau": 0.0, "displacement.zero_sd": 100.0})
    drive, rig = coarse(driven(exact, 7200, (100, 5000), stroke=(0.0, 100.0)), exact, 5)
    runs = [live(model, rig, drive, seed, process=True).recording for seed in (1, 2)]
    trials = Trials([Trial(model, rig, run) for run in runs])
    for found in quality(trials, model):
        assert found.nis == pytest.approx(1.0, abs=0.1), found.channel
        assert found.in_2sd == pytest.approx(0.954, abs=0.02), found.channel
        assert found.whiteness < 0.3 if found.channel == "displacement" else found.whiteness < 0.12
        assert 0.3 < found.blind_nis < 2.5
        assert found.blind_in_2sd > 0.75
    wrong = quality(trials, model.with_values({"nut_friction.power": 75.0}))
    assert max(found.blind_nis for found in wrong) > 5
