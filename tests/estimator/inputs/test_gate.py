"""The gate of the inputs: what jumps is held, what is slow by nature passes, in whatever portions ticks come."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.faults.fault import Fault
from estimator.inputs.gate import InputGate, believable
from estimator.inputs.inputs import InputReader
from estimator.inputs.start import Start

TICKS, AT = 200, 120
START = Start(22.0, 0.0, dict.fromkeys(("ambient", "probe", "nut", "bar", "board", "position"), 0.0))


@pytest.fixture
def run(small, driven):
    """Air that becomes warmer by 3 K an hour, with noise of 30 mK."""
    drive = driven(small, TICKS, (20, 90), stroke=(0.0, 100.0))
    noise = 0.03 * np.random.default_rng(1).standard_normal(TICKS)
    return replace(drive, inputs={**drive.inputs, "ambient": np.round(22 + np.arange(TICKS) / 1200 + noise, 2)})


FAILURES = {
    "85 degC": lambda air: np.full_like(air, 85.0),
    "0 degC": lambda air: np.zeros_like(air),
    "+2 K": lambda air: air + 2.0,
}


@pytest.mark.parametrize("name", FAILURES)
def test_what_jumps_is_held_and_taken_again_when_it_is_back(name, small, run):
    air = run.inputs["ambient"].copy()
    air[AT:170] = FAILURES[name](air[AT:170])
    u = InputReader(small, START).read(replace(run, inputs={**run.inputs, "ambient": air}))
    i = list(small.inputs).index("ambient")
    assert (u.fault[:AT, i] == Fault.NONE).all()
    assert (u.fault[AT:170, i] == Fault.JUMPED).all()
    np.testing.assert_array_equal(u["ambient"][AT:170, 0], air[AT - 1])
    np.testing.assert_array_equal(u["ambient"][170:, 0], air[170:])


@pytest.mark.parametrize("portion", [1, 7, TICKS])
def test_ticks_may_come_in_any_portions(portion, small, run):
    air = run.inputs["ambient"].copy()
    air[AT:], air[60:64] = 85.0, np.nan
    log = replace(run, inputs={**run.inputs, "ambient": air})
    whole, gate = InputGate(small, START).passed(log), InputGate(small, START)
    parts = [gate.passed(log.rows(slice(k, k + portion))) for k in range(0, TICKS, portion)]
    np.testing.assert_array_equal(np.vstack([part[0] for part in parts]), whole[0])
    np.testing.assert_array_equal(np.vstack([part[1] for part in parts]), whole[1])
    assert gate.fault.tolist() == whole[1][-1].tolist()


def test_after_a_long_silence_an_input_may_be_anywhere(small, run):
    air = run.inputs["ambient"].copy()
    air[40 : 40 + 62], air[40 + 62 :] = np.nan, air[40 + 62 :] + 2.0
    i = list(small.inputs).index("ambient")
    passed, fault = InputGate(small, START).passed(replace(run, inputs={**run.inputs, "ambient": air}))
    assert (fault[:, i] == Fault.NONE).all()
    np.testing.assert_array_equal(passed[:, i], air)


def test_an_air_conditioning_that_takes_half_a_minute_is_believed(small, run):
    air = run.inputs["ambient"] + np.interp(np.arange(TICKS), [AT, AT + 30], [0.0, 3.0])
    passed, fault = InputGate(small, START).passed(replace(run, inputs={**run.inputs, "ambient": air}))
    assert not fault.any()
    np.testing.assert_array_equal(passed[:, list(small.inputs).index("ambient")], air)


def test_what_jumps_after_a_long_rise_is_held_too(small, run):
    """What it scatters by is told from tick to tick: a rise of 10 K is none."""
    air = run.inputs["ambient"] + np.interp(np.arange(TICKS), [0, AT], [0.0, 10.0])
    air[AT:] += 2.0
    _, fault = InputGate(small, START).passed(replace(run, inputs={**run.inputs, "ambient": air}))
    held = fault[:, list(small.inputs).index("ambient")] == Fault.JUMPED
    assert np.flatnonzero(held).tolist() == list(range(AT, TICKS))


def test_one_that_stands_still_is_told(small, run):
    air = run.inputs["ambient"].copy()
    air[AT:] = air[AT]
    _, fault = InputGate(small, START).passed(replace(run, inputs={**run.inputs, "ambient": air}))
    i = list(small.inputs).index("ambient")
    assert np.flatnonzero(fault[:, i] == Fault.STUCK).tolist() == list(range(AT + 20, TICKS))


def test_a_start_far_from_the_screw_is_not_believed(small):
    found = believable(
        {"ambient": 85.0, "nut": -5.0, "bar": 0.0, "board": 1.0, "probe": 21.0, "position": 0.0}, small, START
    )
    assert np.isnan([found[name] for name in ("ambient", "nut", "bar")]).all()
    assert [found[name] for name in ("board", "probe", "position")] == [1.0, 21.0, 0.0]
