"""Runs that could be made stay inside what was seen; and how the surroundings would go on them."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.next_run.foretold import REST_S, planned
from estimator.next_run.plans import plans
from estimator.next_run.surroundings import foretold, learned
from estimator.record import Recording
from estimator.rig import Channel, Rig, Signal

SPINDLE = Rig("spindle", 1.0, {}, {"speed": Signal(unit="rpm"), "oil": Signal()})


def test_a_table_stays_inside_its_travel_and_its_speeds(bar, plain, lives):
    tried = plans(bar, lives(plain))
    assert {plan.speed_m_min for plan in tried} == {5.0, 10.0, 20.0}
    assert min(plan.stroke_mm[0] for plan in tried) >= 0.0
    assert max(plan.stroke_mm[1] for plan in tried) <= 100.0
    run = planned(tried[-1], bar, 22.0)
    driving = run.omega > 0
    assert driving.sum() * bar.tick_s == tried[-1].drive_s
    assert run.omega.max() == pytest.approx(174.5)
    np.testing.assert_allclose(run.coverage.sum(axis=1), run.coverage[0].sum())
    assert not driving[run.time_s <= REST_S].any()


def test_where_one_speed_was_seen_half_of_it_is_tried_too(bar, plain, lives):
    tried = plans(bar, lives(plain)[:1])
    assert {plan.speed_m_min: round(plan.omega, 2) for plan in tried} == {10.0: 87.25, 20.0: 174.5}


def test_a_table_that_never_moved_has_none(bar, plain, lives):
    still = [replace(run, omega=np.zeros(len(run))) for run in lives(plain)[:1]]
    assert plans(bar, still) == []


def still_rig(on: dict[str, np.ndarray]) -> tuple[Rig, Recording]:
    rig = Rig("bench", 2.0, {}, {name: Signal(unit="W") for name in on} | {"air": Signal()})
    ticks = len(next(iter(on.values())))
    gaps = np.zeros((ticks, 0))
    inputs = {**on, "air": np.full(ticks, 21.0)}
    return rig, Recording("r", 2.0 * np.arange(ticks), gaps, gaps, inputs, np.zeros(ticks), np.zeros((ticks, 0)))


def test_a_rig_without_a_table_has_steps_of_its_inputs_at_levels_seen():
    left = np.repeat([0.0, 20.0, 20.0, 50.0], 200)
    rig, recording = still_rig({"left": left, "right": np.repeat([0.0, 30.0], 400)})
    tried = plans(rig, [recording])
    assert {tuple(sorted(plan.levels.items())) for plan in tried} == {
        (("left", 20.0),), (("left", 50.0),), (("right", 30.0),), (("right", 15.0),),
        (("left", 50.0), ("right", 30.0)),
    }  # fmt: skip
    assert {plan.drive_s + plan.stop_s for plan in tried} <= {1000.0, 1200.0, 1600.0}
    run = planned(tried[0], rig, 21.0)
    assert (run.inputs["left"] == 20.0).sum() * rig.tick_s == tried[0].drive_s
    assert not run.inputs["right"].any()
    assert (run.inputs["air"] == 21.0).all()


def test_a_spindle_turns_at_speeds_seen():
    ticks = np.repeat([0.0, 3000.0], 400)
    gaps = np.zeros((800, 0))
    omega = ticks / 60 * 2 * np.pi
    recording = Recording("r", np.arange(800.0), gaps, gaps, {"speed": ticks, "oil": np.full(800, 25.0)}, omega, gaps)
    turning = {planned(plan, SPINDLE, 25.0).omega.max() for plan in plans(SPINDLE, [recording])}
    assert sorted(turning) == pytest.approx([omega.max() / 2, omega.max()])


def test_an_input_that_warms_with_the_rig_is_foretold_and_weather_stays_where_it_is():
    time_s = np.arange(4000.0)
    mean = 5.0 * (1 - np.exp(-time_s / 800.0))
    board = np.zeros(4000)
    for k in range(3999):
        board[k + 1] = board[k] + 1e-3 * mean[k] - 2e-3 * board[k]
    rig = Rig("r", 1.0, {"T1": Channel(at_mm=5.0)}, {"board": Signal(), "weather": Signal()})
    weather = np.random.default_rng(1).standard_normal(4000)
    channels, none = (20.0 + mean)[:, None], np.zeros((4000, 0))
    channels[[0, *range(1000, 1100)]] = np.nan  # scans that were lost
    inputs = {"board": 20.0 + board, "weather": 20.0 + weather}
    laws = learned([Recording("r", time_s, channels, channels * 0, inputs, np.zeros(4000), none)], rig)
    again = foretold(laws, mean, np.zeros(4000), 1.0)
    np.testing.assert_allclose(again["board"], board, atol=0.05)
    assert not again["weather"].any()
