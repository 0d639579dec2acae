"""Thermometers that are not seen: as the filter without them predicts, and honest where a model lived the recording."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.coarse import coarse
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.filter import Filter
from estimator.fit.noise import of_places
from estimator.fit.tune import Factors, scaled
from estimator.fit.unseen import EVERY, on_screw, unseen
from estimator.rig import Channel
from tests.conftest import stepped

TICK_S = 10
LOOK = 60 // TICK_S
GAIN_SD = 0.01
NOISE = 10.0


@pytest.fixture(scope="module")
def lives(small, small_model, driven, live):
    """Model, rig, and of_seed(seed): a life of the bar with seven thermometers, not named as their places are."""
    places = {"T1": 195.0, "T2": 5.0, "T3": 35.0, "T4": 70.0, "T5": 100.0, "T6": 130.0, "T7": 160.0}
    channels = {name: Channel(at_mm=x) for name, x in places.items()} | {"displacement": Channel(unit="um")}
    exact = replace(small.screw, expansion_tolerance=0.0, knots_mm=(0, 45, 90, 145, 200))
    rig = replace(small, channels=channels, screw=exact)
    still = {
        "thermometers.tau": 0.0,
        "thermometers.zero_walk": 0.0,
        "thermometers.gain_sd": 0.0,
        "conduction.noise": NOISE,
    }
    model = small_model.with_values({**still, "displacement.zero_sd": 100.0})
    drive, slow = coarse(driven(rig, 3610, (50, 2400), stroke=(0.0, 100.0)), rig, TICK_S)
    return model, slow, lambda seed: live(model, slow, drive, seed=seed, process=True).recording


@pytest.fixture(scope="module")
def trials(lives) -> list[Trial]:
    model, rig, of_seed = lives
    return [Trial(model, rig, of_seed(seed)) for seed in range(4)]


def _after_the_first(trial: Trial, hidden: list[int]):
    """Mutes some channels once the run has begun."""
    first, which = trial.recording.time_s[0], np.isin(np.arange(len(trial.rig.names)), hidden)
    return lambda time_s: which & (time_s > first)


def test_one_in_three_along_the_screw_is_predicted_by_the_filter_that_never_reads_it(lives, trials):
    """Tick by tick by the live filter, with the channel muted after the first sample."""
    model, rig, _ = lives
    doubtful = model.with_values({"thermometers.gain_sd": GAIN_SD})
    trial = Trial(model, rig, trials[1].recording.rows(slice(37)))  # in which none is suspected
    found, wanted, posed = unseen(trial, doubtful), [], trial.pose(model)
    run, start = posed.run, posed.forcing.readings.rows @ posed.run.z[0]
    assert [rig.names[i] for i in on_screw(posed)] == ["T2", "T3", "T4", "T5", "T6", "T7", "T1"]
    for first in range(EVERY):
        hidden = on_screw(posed)[first::EVERY]
        track = stepped(Filter(model, rig, mute=_after_the_first(trial, hidden)), trial.recording)
        for i in hidden:
            for k in range(LOOK, len(track.time_s), LOOK):
                rise = run.lagged[k - 1, i] - start[i]
                error, sd = track.measured[k, i] - track.predicted[k, i], track.innovation_sd[k, i]
                wanted.append((error, np.hypot(sd, GAIN_SD * rise), i))
    assert len(wanted) == 7 * 6
    np.testing.assert_allclose(np.column_stack([found.error, found.sd, found.channel]), wanted, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.weight, 0.6 / 42)


def test_of_errors_as_large_as_the_noise_says_most_are_within_two_sd(lives, trials):
    errors = [unseen(trial, lives[0]) for trial in trials]
    z = np.concatenate([found.error / found.sd for found in errors])
    assert 0.7 < np.mean(z**2) < 1.4
    assert np.mean(np.abs(z) < 2.0) > 0.90


@pytest.mark.parametrize("off", [0.2, 5.0])
def test_the_screws_own_noise_is_found_by_what_is_not_seen(lives, trials, off):
    model = lives[0].with_values({"conduction.noise": NOISE * off})
    better, factors = scaled(model, Trials(trials), ["conduction.noise"])
    assert factors.places * off == pytest.approx(1.0, rel=0.35)
    assert factors.others == 1.0
    assert better["conduction.noise"] == pytest.approx(factors.places * NOISE * off)


def test_noise_that_is_enough_is_not_raised(lives, trials):
    model = lives[0].with_values({"conduction.noise": 2.0 * NOISE})
    assert scaled(model, Trials(trials), ["conduction.noise"], lowest=0.0) == (model, Factors())


def test_only_noise_from_place_to_place_is_the_screws_own(lives, trials):
    model = lives[0]
    paths = ["conduction.noise", "nut_body.noise", "nut_friction.noise"]
    assert of_places(paths, model, trials[0]) == ["conduction.noise"]


def test_a_screw_with_four_thermometers_leaves_none_unseen(small, small_model, driven, live):
    recording = live(small_model, small, driven(small, 700, (50, 400), stroke=(0.0, 100.0)), seed=1).recording
    assert len(unseen(Trial(small_model, small, recording), small_model).error) == 0


def test_a_thermometer_that_was_not_read_or_is_refused_is_not_scored(lives):
    model, rig, of_seed = lives
    recording = of_seed(0)
    channels = recording.channels.copy()
    channels[1:, rig.index("T4")] = np.nan
    channels[-3 * LOOK :, rig.index("T6")] += 20.0
    trial = Trial(model, rig, replace(recording, channels=channels))
    channel = list(unseen(trial, model).channel)
    assert channel.count(rig.index("T4")) == 0
    assert channel.count(rig.index("T6")) == channel.count(rig.index("T5")) - 3
