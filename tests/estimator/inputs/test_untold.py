"""When nothing told what the machine did: parts of a recording, and ticks that the filter takes for anything."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.inputs.untold import LEAST_S, UNTOLD_S, Untold, gaps_s, stretches
from estimator.rig import Signal

TICKS = 1500


@pytest.fixture
def turning(small):
    """A rig that tells of its drive."""
    return replace(small, inputs={**small.inputs, "speed": Signal(unit="rpm")})


@pytest.fixture
def run(small, driven):
    """A recording of which the drive is told all the time, at a tick of one second."""
    return driven(small, TICKS, (20, 90), stroke=(0.0, 100.0))


def silent(run, *spans):
    omega = run.omega.copy()
    for a, b in spans:
        omega[a:b] = np.nan
    return replace(run, omega=omega)


def test_a_recording_is_parted_where_the_drive_is_not_told_for_long(turning, run):
    log = silent(run, (400, 700), (1000, 1000 + int(UNTOLD_S) - 2))
    first, second = stretches(log, turning)
    assert (first.time_s[0], first.time_s[-1]) == (run.time_s[0], run.time_s[399])
    assert (second.time_s[0], second.time_s[-1]) == (run.time_s[700], run.time_s[-1])
    assert second.name == f"{run.name} from {run.time_s[700]:.0f} s"
    assert first.fingerprint == second.fingerprint == log.fingerprint
    assert gaps_s(log, turning) == [(run.time_s[399], run.time_s[700])]
    np.testing.assert_array_equal(second.channels, run.channels[700:])


def test_what_is_told_all_the_time_or_never_is_one(turning, run):
    for log in (run, silent(run, (0, TICKS))):
        assert stretches(log, turning)[0] is log


def test_a_short_stretch_is_no_recording_unless_there_is_no_other(turning, run):
    first, last = int(LEAST_S) - 1, TICKS - int(LEAST_S)
    assert [len(part) for part in stretches(silent(run, (first, last)), turning)] == [int(LEAST_S)]
    assert len(stretches(silent(run, (first, last + 1)), turning)[0]) == TICKS


@pytest.mark.parametrize("portion", [1, 7, TICKS])
def test_the_drive_may_have_run_as_soon_as_it_is_not_told(portion, turning, run):
    log, untold = silent(run, (400, 420), (1490, TICKS)), Untold(turning)
    parts = [untold.unseen(log.rows(slice(k, k + portion))) for k in range(0, TICKS, portion)]
    np.testing.assert_array_equal(np.concatenate(parts), np.isnan(log.omega))


@pytest.mark.parametrize("portion", [1, 7, TICKS])
def test_without_a_drive_inputs_stand_until_nothing_at_all_has_come_for_long(portion, small, run):
    last, back = 400, 700
    ambient = np.full(TICKS, 20.0)
    ambient[last + 1 : back] = np.nan
    log = replace(run, channels=np.full_like(run.channels, np.nan), inputs={"ambient": ambient})
    untold = Untold(small)
    parts = [untold.unseen(log.rows(slice(k, k + portion))) for k in range(0, TICKS, portion)]
    expected = np.zeros(TICKS, dtype=bool)
    expected[last + 1 + int(UNTOLD_S) : back] = True
    np.testing.assert_array_equal(np.concatenate(parts), expected)
    assert [len(part) for part in stretches(log, small)] == [last + 1, TICKS - back]
