"""Taken back when it has been well for a minute of readings, however seldom these come."""

import numpy as np
import pytest

from estimator.faults.fault import Fault
from estimator.faults.jumps import Deviations
from estimator.faults.recovery import LONGEST_S, WELL_S, Recovery

SILENT_S = 120.0


def taken_back_s(readings_s: np.ndarray, well: np.ndarray, portion: int = 7, recovery: Recovery | None = None) -> float:
    """When a channel that broke at 0 s and reads at these times, well or not, is taken back, s; inf: never."""
    if recovery is None:
        recovery = Recovery(np.array([SILENT_S]))
        recovery.isolate(0, Fault.STUCK, 0.0, 0.0)
    time_s = np.arange(1.0, readings_s[-1] + 2.0)
    value, beyond = np.full((len(time_s), 1), np.nan), np.zeros((len(time_s), 1), dtype=bool)
    at = np.searchsorted(time_s, readings_s)
    value[at, 0], beyond[at, 0] = 0.1, ~well
    for first in range(0, len(time_s), portion):
        some = slice(first, first + portion)
        of = Deviations(value[some], np.ones_like(value[some]), beyond[some], value[some], value[some])
        progress = recovery.compare(time_s[some], of, np.zeros_like(value[some]), np.array([Fault.STUCK]))
        back = int(progress.back[:, 0].argmax())
        recovery.learn(progress, back + 1 if progress.back.any() else len(progress.back))
        if progress.back.any():
            return float(time_s[some][back])
    return np.inf


@pytest.mark.parametrize("every_s", [1.0, 3.0, 25.0])
def test_a_minute_of_readings_that_are_well(every_s):
    readings_s = np.arange(5.0, 400.0, every_s)
    back = taken_back_s(readings_s, readings_s > 50.0)
    first = readings_s[readings_s > 50.0][0]
    assert first + WELL_S <= back < first + WELL_S + every_s


def test_one_reading_that_is_not_well_begins_it_anew():
    readings_s = np.arange(5.0, 400.0, 3.0)
    assert taken_back_s(readings_s, readings_s % 30.0 != 20.0) == np.inf


def test_a_silence_does_not_count():
    """As the hour at rest, in which a displacement has no reading."""
    drives = np.append(np.arange(5.0, 45.0, 3.0), np.arange(2000.0, 2100.0, 3.0))
    back = taken_back_s(drives, np.ones(len(drives), dtype=bool))
    assert 2000.0 + WELL_S - 40.0 <= back < 2000.0 + WELL_S - 30.0


def test_a_drift_is_forgiven_after_ten_hours_that_were_well():
    recovery = Recovery(np.array([SILENT_S]))
    recovery.isolate(0, Fault.DRIFTING, 0.0, 0.0)
    assert taken_back_s(np.arange(1.0, 4000.0), np.ones(3999, dtype=bool), 500, recovery) < LONGEST_S + 2.0
    recovery.isolate(0, Fault.STUCK, 0.0, now_s := 12.0 * 3600.0)
    later_s = np.arange(now_s, now_s + 200.0)
    assert taken_back_s(later_s, np.ones(200, dtype=bool), 500, recovery) <= now_s + WELL_S + 1.0
