"""The filter's own sigma against what really happened, on rigs whose noise is exactly the model's.

The screw's expansion coefficient is off by what its tolerance allows, drawn anew for every seed. Whole recordings at
once: that they give the numbers of the filter, tick by tick, is tested beside the replay (batch/test_replay.py).
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from estimator.batch.replay import Replay, replay
from estimator.model import Value


def outcomes(small, model, driven, live, seeds: int, seconds: int):
    """Errors of the elongation in sigma at a few late ticks, (seeds, ticks), and after the fact at three ticks; NIS
    summed, and over how many readings."""
    late = np.arange(seconds // 3, seconds, 10)
    drive = driven(small, seconds, (10, seconds * 2 // 3), stroke=(0.0, 100.0))
    errors, smooth, nis, count = [], [], 0.0, 0
    expansion = small.expansion_tolerance * np.random.default_rng(7).standard_normal(seeds)
    for seed in range(seeds):
        lived = live(model, small, drive, seed, process=True, expansion=expansion[seed])
        found = Replay(model, small, lived.recording, None, lambda _: None)
        track, smoothed = found.track, found.smoothed()
        errors.append(((track.elongation_um - lived.elongation_um) / np.maximum(track.sigma_um, 1e-9))[late])
        smooth.append((smoothed.elongation_um - lived.elongation_um)[20:80:20] / smoothed.sigma_um[20:80:20])
        nis, count = nis + np.nansum(track.nis[1:]), count + track.nis_channels[1:].sum()
    return np.array(errors), np.array(smooth), nis, int(count)


@pytest.fixture(scope="module")
def exact(small_model):
    """The small model without lag and with equal gains: then the filter's model of its own thermometers is exact."""
    return small_model.with_values(
        {"thermometers.gain_sd": 0.0, "thermometers.tau": 0.0, "conduction.noise": 8.0, "displacement.zero_sd": 20.0}
    )


def judge(errors, nis: float, count: int, coverage: tuple[float, float]) -> None:
    inside = (abs(errors) <= 2).mean()
    assert coverage[0] <= inside <= coverage[1]
    assert errors.std() == pytest.approx(1, abs=0.1)
    lo, hi = chi2.ppf([0.001, 0.999], count)
    assert lo <= nis <= hi


OFF = {"nut_friction.power": 0.05, "nut_body.capacity": 0.2, "still_air.h": 0.2, "displacement.probe": 0.5}


def known_to(rig, tolerance: float):
    return replace(rig, screw=replace(rig.screw, expansion_tolerance=tolerance))


@pytest.mark.usefixtures("no_lies")
def test_elongation_is_inside_two_sigma_as_often_as_it_should_after_the_fact_too(small, exact, driven, live):
    """80 runs; after the fact of three ticks each: 228 of 240 are expected inside, with an sd of 3.4 if they were
    independent."""
    errors, smooth, nis, count = outcomes(known_to(small, 0.1), exact, driven, live, seeds=80, seconds=90)
    judge(errors, nis, count, (0.93, 0.97))
    assert 0.90 <= (abs(smooth) <= 2).mean() <= 0.99
    assert smooth.std() == pytest.approx(1, abs=0.15)


@pytest.mark.usefixtures("no_other_machine", "no_lies")
def test_with_parameters_and_gains_that_are_off_it_is_inside_two_sigma_as_often_as_it_should(
    small, exact, driven, live
):
    """Each run of another rig: parameters off by as much as the model says of them, thermometers by their gains."""
    rig, drive, errors = known_to(small, 0.01), driven(small, 200, (10, 130), stroke=(0.0, 100.0)), []
    doubtful = exact.with_values({path: Value(exact[path], share * exact[path]) for path, share in OFF.items()})
    doubtful = doubtful.with_values({"thermometers.gain_sd": 0.004})
    for seed in range(60):
        dice = np.random.default_rng([seed, 1])
        own = exact.with_values({path: exact[path] * (1 + share * dice.normal()) for path, share in OFF.items()})
        made = live(own, rig, drive, seed, process=True, expansion=0.01 * dice.normal())
        channels, gain = made.recording.channels, np.append(0.004 * dice.standard_normal(4), 0.0)
        recording = replace(made.recording, channels=channels + gain * (channels - channels[0]))
        track = replay(doubtful, rig, recording)
        at = [50, 100, 140, 199]
        errors.append((track.elongation_um - made.elongation_um)[at] / track.sigma_um[at])
    assert 0.90 <= (abs(np.array(errors)) <= 2).mean() <= 0.99
    assert np.std(errors) == pytest.approx(1, abs=0.15)


@pytest.mark.study
@pytest.mark.usefixtures("no_lies")
@pytest.mark.parametrize("tolerance", [0.01, 0.1])
def test_elongation_is_inside_two_sigma_in_a_long_study(tolerance, small, exact, driven, live):
    errors, _, nis, count = outcomes(known_to(small, tolerance), exact, driven, live, seeds=800, seconds=300)
    judge(errors, nis, count, (0.94, 0.965))


def test_a_filter_that_believes_too_little_noise_is_found_out(small, exact, driven, live):
    """The same data under a model with a fifth of the noise: the test above would fail."""
    drive = driven(small, 90, (10, 60), stroke=(0.0, 100.0))
    nis, count = 0.0, 0
    for seed in range(5):
        lived = live(exact, small, drive, seed, process=True)
        track = replay(exact.with_values({"conduction.noise": 0.5}), small, lived.recording)
        nis, count = nis + np.nansum(track.nis[1:]), count + track.nis_channels[1:].sum()
    assert nis > chi2.ppf(0.999, count)


def test_a_coefficient_believed_too_well_is_found_out(small, exact, driven, live):
    """Off by 10 % and believed to be exact: all errors go one way."""
    drive, late = driven(small, 90, (10, 60), stroke=(0.0, 100.0)), []
    for seed in range(5):
        lived = live(exact, small, drive, seed, process=True, expansion=0.1)
        track = replay(exact, known_to(small, 0.0), lived.recording)
        late.append((track.elongation_um - lived.elongation_um)[40:] / track.sigma_um[40:])
    assert np.mean(late) < -1
