"""Alarms: how often they are false, what they find, and when they end."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import poisson

from estimator.alarms.alarms import Alarms
from estimator.alarms.window import NIS_ALLOWED, WINDOWS, Window, WindowTest
from estimator.faults.fault import MAY_DRIFT, Fault
from estimator.rig import Rig
from estimator.step import Mode, Step

SD = 0.05


def step_of(rig: Rig, k: int, innovation: np.ndarray, nis: float, measured: np.ndarray | None = None) -> Step:
    """A tick with these innovations; all channels fused unless NaN."""
    m, fused, empty = len(rig.names), np.isfinite(innovation), np.empty(0)
    return Step(
        time_s=k * rig.tick_s, mode=Mode.UPDATE, elongation_um=0.0, sigma_um=0.1, open_loop_um=0.0, profile_C=empty,
        profile_sd_K=empty, bodies_C=empty, error_at_table_um=0.0, error_at_table_sd_um=0.0, position_mm=0.0,
        names=tuple(rig.names),
        measured=innovation if measured is None else measured, predicted=np.zeros(m), innovation=innovation,
        innovation_sd=np.full(m, SD), fused=fused,
        fault=np.zeros(m, dtype=int), input_fault=np.zeros(len(rig.inputs), dtype=int),
        since_s=np.full(m, np.nan), may_drift_K=np.zeros(m), lacks_K=np.zeros(m), unsure_um=0.0, off_share=0.0,
        shift_mm=0.0, jump=np.zeros(m),
        begins=False, why=tuple("" if f else "not measured" for f in fused),
        open_loop=np.zeros(m), nis=nis, nis_channels=int(fused.sum()),
    )  # fmt: skip


def lived(
    rig: Rig, ticks: int, bias_sd: float = 0.0, spread: float = 1.0, seed: int = 1, false_s: float = 3600.0,
    lasts: float = 0.0,
):  # fmt: skip
    """Alarms of a rig whose innovations are off by so much, a part of which lasts: (tick, begun, over)."""
    dice, alarms, own = np.random.default_rng(seed), Alarms(rig, false_s), np.zeros(len(rig.names))
    for k in range(ticks):
        own = lasts * own + np.sqrt(1.0 - lasts**2) * dice.standard_normal(len(rig.names))
        scaled = spread * own + bias_sd
        begun, over = alarms.step(step_of(rig, k, SD * scaled, float((scaled**2).sum())))
        yield k, begun, over


def test_false_alarms_are_no_more_than_stated(small):
    """A rig that is off by the whole allowance; the rate is set to two an hour, so that there is one to count."""
    stated, false_s = 5, 1800.0
    ticks = int(stated * false_s / small.tick_s)
    off = max(window.bias for window in WINDOWS[1:])
    count = sum(len(begun) for _, begun, _ in lived(small, ticks, bias_sd=off, false_s=false_s))
    assert count <= poisson.isf(1e-4, stated)
    spread = sum(len(begun) for _, begun, _ in lived(small, ticks, spread=np.sqrt(NIS_ALLOWED), false_s=false_s))
    assert spread <= poisson.isf(1e-4, stated)


@pytest.mark.parametrize("window", WINDOWS, ids=["minute", "ten"])
def test_one_window_alone_fails_as_often_as_it_says(small, window: Window):
    """Bias at the edge of the allowance: the share of windows that fail is that of the normal quantile."""
    test = WindowTest(small, window, false_s=20 * window.ticks * small.tick_s)
    dice, failed, tried = np.random.default_rng(5), 0, 600
    for _ in range(tried):
        sums = window.bias + dice.standard_normal(len(small.names)) / np.sqrt(window.ticks)
        test._count[:], test._sum[:] = window.ticks, sums * window.ticks
        failed += int(test._biased().sum())
    expected = tried * len(small.names) * test.share / 2
    assert poisson.ppf(1e-4, expected) <= failed <= poisson.isf(1e-4, expected)


def test_a_right_rig_raises_none(small):
    assert not [alarm for _, begun, _ in lived(small, 12_000) for alarm in begun]


def test_a_bias_is_found_named_and_passes(small):
    alarms, dice = Alarms(small), np.random.default_rng(2)
    told: list[tuple[int, str, str]] = []
    for k in range(600):
        scaled = dice.standard_normal(len(small.names))
        scaled[1] += 4.0 if 130 <= k < 300 else 0.0
        begun, over = alarms.step(step_of(small, k, SD * scaled, float((scaled**2).sum())))
        told += [(k, "+", a.channel) for a in begun if a.kind == "bias" and a.over_s == WINDOWS[0].ticks * small.tick_s]
        told += [(k, "-", a.channel) for a in over if a.kind == "bias" and a.over_s == WINDOWS[0].ticks * small.tick_s]
    name = small.names[1]
    assert told == [(179, "+", name), (359, "-", name)]


def test_innovations_twice_too_large_are_found(small):
    found = [(k, a) for k, begun, _ in lived(small, 200, spread=2.0, false_s=30 * 86400.0, lasts=0.9) for a in begun]
    k, alarm = next((k, a) for k, a in found if a.kind == "nis")
    assert k == 59
    assert alarm.text == "the innovations are 1.8 times as large as they should be"
    assert alarm.since_s == 0.0


@pytest.mark.parametrize(("spread", "kind"), [(2.0, "scatter"), (5.0, "nis")])
def test_sensors_that_scatter_twice_as_much_are_told_and_no_reason_to_distrust_and_five_times_are(spread, kind, small):
    told = [alarm for _, begun, _ in lived(small, 700, spread=spread, false_s=30 * 86400.0) for alarm in begun]
    assert {alarm.kind for alarm in told} == {kind}
    if kind == "scatter":
        assert told[0].text == "the thermometers scatter 1.8 times as much as the model says: ballscrew tune"


def test_a_machine_that_is_not_the_models_is_told_until_it_is_again(small):
    """By the share that parameters are off for a minute, and not again and again where that is near the limit."""
    alarms, told, share = Alarms(small), [], {100: 0.12, 200: 0.2, 300: 0.12, 400: 0.16, 500: 0.08}
    for k in range(600):
        off_share = 0.3 if 30 <= k < 80 else share.get(k // 100 * 100, 0.0)
        step = replace(step_of(small, k, np.zeros(len(small.names)), 0.0), time_s=float(k), off_share=off_share)
        begun, over = alarms.step(step)
        told += [(k, "+", a.kind, a.since_s, a.text) for a in begun] + [(k, "-", a.kind) for a in over]
    text = "the model is not this machine's: its parameters are off by some 20%; the estimate's sd allows for it"
    assert told == [(260, "+", "machine", 200.0, text), (500, "-", "machine")]


def test_a_broken_thermometer_is_named_since_when_until_it_is_well(small):
    alarms, name = Alarms(small), small.names[1]
    told = []
    for k in range(40):
        step = step_of(small, k, np.zeros(len(small.names)), 0.0)
        fault = {10: Fault.JUDGED, 20: Fault.STUCK}.get(k // 10 * 10, Fault.NONE)
        step.fault[1], step.since_s[1] = fault, 10.0 * small.tick_s if fault else np.nan
        begun, over = alarms.step(step)
        told += [(k, "+", a.kind, a.channel, a.since_s) for a in begun] + [(k, "-", a.kind) for a in over]
    assert told == [(20, "+", "stuck", name, 10.0 * small.tick_s), (30, "-", "stuck")]


def test_a_thermometer_that_may_drift_is_named_until_it_is_trusted_again_or_accused(small):
    alarms, name = Alarms(small), small.names[1]
    told = []
    for k in range(40):
        step = step_of(small, k, np.zeros(len(small.names)), 0.0)
        step.may_drift_K[1], step.since_s[1] = (0.1, 10.0) if k // 10 in (1, 2) else (0.0, np.nan)
        step.fault[1] = Fault.DRIFTING if k >= 20 else Fault.NONE
        begun, over = alarms.step(step)
        told += [(k, "+", a.kind, a.channel) for a in begun] + [(k, "-", a.kind) for a in over]
        if k == 10:
            assert begun[0].since_s == 10.0
    assert told == [(10, "+", MAY_DRIFT, name), (20, "+", "drifting", name), (20, "-", MAY_DRIFT)]
