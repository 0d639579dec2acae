"""Ten blind minutes: against a plain loop with the filter, and honest on recordings that the model itself lived."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.accuracy.blind import Scored, blind
from estimator.batch.coarse import coarse
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.filter import Filter
from estimator.fit.tune import scaled
from estimator.rig import Rig
from tests.conftest import stepped

TICK_S = 10
STRETCH = 600 // TICK_S
LOOK = 60 // TICK_S
PROCESS = ["conduction.noise", "nut_body.noise", "nut_friction.noise"]


@pytest.fixture(scope="module")
def model(small_model):
    """What a life with scattering heat can show: no lags, zeros that stay."""
    still = {"thermometers.tau": 0.0, "thermometers.zero_walk": 0.0, "displacement.zero_walk": 0.0}
    return small_model.with_values({**still, "displacement.zero_sd": 100.0})


@pytest.fixture(scope="module")
def make(small, model, driven, live):
    """make(seed, minutes, model): a recording that the model lived, on a rig whose coefficient is exact."""
    exact = replace(small, screw=replace(small.screw, expansion_tolerance=0.0))
    drives = {}

    def run(seed: int, minutes: int = 60, lived_by=model) -> tuple[Rig, object]:
        if minutes not in drives:
            ticks = driven(exact, 60 * minutes + TICK_S, (50, 40 * minutes), stroke=(0.0, 100.0))
            drives[minutes] = coarse(ticks, exact, TICK_S)
        drive, rig = drives[minutes]
        return rig, live(lived_by, rig, drive, seed=seed, process=True).recording

    return run


@pytest.fixture(scope="module")
def honest(make, model) -> list[Trial]:
    """Six recordings of an hour."""
    runs = [make(seed) for seed in range(6)]
    return [Trial(model, rig, run) for rig, run in runs]


def by_filter(model, rig, run) -> list[tuple[float, float, int]]:
    """Error, sd and channel of the last reading in the last minute of each blind stretch, tick by tick."""
    found, stretch_ticks, look = [], round(600 / rig.tick_s), round(60 / rig.tick_s)
    for first_seen in (True, False):
        stretch = (
            np.arange(len(run) - 1) // stretch_ticks + (not first_seen)
        ) % 2 == 1  # blind, from the second sample on
        hidden = dict(zip(run.time_s[1:], stretch, strict=True))
        track = stepped(Filter(model, rig, lambda t, hidden=hidden: np.full(len(rig.names), hidden.get(t, False))), run)
        for k in range(stretch_ticks, len(run), stretch_ticks):
            if not stretch[k - 1]:
                continue
            for i in range(len(rig.names)):
                read = [j for j in range(k - look + 1, k + 1) if np.isfinite(run.channels[j, i])]
                if read and track.fused[: read[-1], i].any():
                    found.append((track.innovation[read[-1], i], track.innovation_sd[read[-1], i], i))
    return sorted(found)


def scored(found: Scored) -> list[tuple[float, float, int]]:
    return sorted(zip(found.error, found.sd, found.channel, strict=True))


def test_it_is_what_a_filter_says_that_is_blind_every_other_ten_minutes(make, model):
    """With gaps: the last reading of the last minute counts, and none where there is none."""
    rig, run = make(3, 30)
    run.channels[STRETCH - 1 : STRETCH + 1, 0] = np.nan
    run.channels[2 * STRETCH - LOOK + 1 : 2 * STRETCH + 1, 1] = np.nan
    expected = by_filter(model, rig, run)
    found = blind(Trial(model, rig, run), model)
    assert len(found.error) == 3 * 5 - 1
    np.testing.assert_allclose(scored(found), expected, rtol=1e-9, atol=1e-9)


def test_minutes_are_minutes_at_any_tick(half, model, driven, live):
    """Ten ticks of half a second in one."""
    drive, rig = coarse(driven(half, 1205.0, (50, 800), stroke=(0.0, 100.0)), half, 10)
    run = live(model, rig, drive, seed=4, process=True).recording
    found = blind(Trial(model, rig, run), model)
    np.testing.assert_allclose(scored(found), by_filter(model, rig, run), rtol=1e-9, atol=1e-9)
    assert len(found.error) == 2 * 5


def test_a_zero_that_no_reading_has_told_yet_is_not_scored(make, model):
    """The displacement is first read in the second of four stretches: only the third and the fourth can judge it."""
    rig, run = make(3, 40)
    run.channels[: STRETCH + 5, 4] = np.nan
    expected = by_filter(model, rig, run)
    found = blind(Trial(model, rig, run), model)
    np.testing.assert_allclose(scored(found), expected, rtol=1e-9, atol=1e-9)
    assert (found.channel == 4).sum() == 2
    assert (abs(found.error[found.channel == 4]) < 10).all()


def test_thermometers_together_weigh_as_one(honest, model):
    found = blind(honest[0], model)
    np.testing.assert_array_equal(found.weight, np.where(found.channel < 4, 0.25, 1.0))
    each = np.log(2 * np.pi * found.sd**2) + (found.error / found.sd) ** 2
    assert found.loglike == pytest.approx(-0.5 * (each[found.channel < 4].sum() / 4 + each[found.channel == 4].sum()))


def test_what_is_blind_influences_no_prediction(make, model):
    """Other readings in the second ten of twenty minutes: each error moves by its own reading's change, no sd does."""
    rig, run = make(5, 20)
    change = np.zeros_like(run.channels)
    change[STRETCH + 1 :] = 0.05 * np.random.default_rng(0).standard_normal((STRETCH, 5))
    other = Trial(model, rig, replace(run, channels=run.channels + change))
    before, after = blind(Trial(model, rig, run), model), blind(other, model)
    late = np.arange(len(before.error)) < 5  # scored in the first of the two passes
    np.testing.assert_array_equal(after.channel, before.channel)
    np.testing.assert_allclose(after.sd, before.sd, rtol=1e-12)
    np.testing.assert_allclose((after.error - before.error)[~late], 0, atol=1e-12)
    moved = [change[np.flatnonzero(np.isfinite(run.channels[:, i]))[-1], i] for i in before.channel[late]]
    np.testing.assert_allclose((after.error - before.error)[late], moved, rtol=0, atol=1e-9)
    assert np.abs(moved).max() > 0.01


def test_a_recording_shorter_than_ten_minutes_scores_nothing(make, model):
    rig, run = make(5, 20)
    found = blind(Trial(model, rig, run.rows(slice(0, STRETCH - LOOK))), model)
    assert len(found.error) == 0
    assert found.loglike == 0


def test_errors_are_as_large_as_they_say_on_recordings_that_the_model_lived(honest, model):
    found = [blind(trial, model) for trial in honest]
    z2 = np.concatenate([(each.error / each.sd) ** 2 for each in found])
    assert len(z2) > 150
    assert z2.mean() == pytest.approx(1.0, abs=0.25)
    assert (z2 < 4).mean() == pytest.approx(0.954, abs=0.04)


def test_too_little_process_noise_is_too_sure_and_too_much_not_sure_enough(honest, model):
    def z2(factor: float) -> float:
        other = model.with_values({path: factor * model[path] for path in PROCESS})
        return np.mean(np.concatenate([(b.error / b.sd) ** 2 for b in (blind(trial, other) for trial in honest)]))

    assert z2(0.2) > 4
    assert z2(5.0) < 0.25


def test_the_composite_likelihood_is_largest_near_the_true_process_noise(honest, model):
    def value(factor: float) -> float:
        other = model.with_values({path: factor * model[path] for path in PROCESS})
        return sum(blind(trial, other).loglike for trial in honest)

    factors = 1.5 ** np.arange(-5.0, 6.0)
    best = factors[np.argmax([value(factor) for factor in factors])]
    assert 1 / 1.6 < best < 1.6
    _, found = scaled(model, Trials(honest), PROCESS)
    assert 1 / 1.5 < found.others < 1.5
    assert value(found.others) >= value(best) - 1e-6
