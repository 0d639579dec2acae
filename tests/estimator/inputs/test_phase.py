"""What the machine was doing: every tick in one phase, the hour of cooling after a stop, the speed of each drive."""

import numpy as np

from estimator.inputs.phase import PHASES, cooling, phase_of, speed_of, stops, turns
from estimator.rig import AT_REST


def test_a_screw_turns_above_the_rest_and_not_where_nothing_is_known():
    assert turns(np.array([0.0, AT_REST, 1.01 * AT_REST, np.nan])).tolist() == [False, False, True, False]


def test_phases_and_speeds_share_the_ticks_out(rig, driven):
    drive = driven(rig, 1500, (20, 600))
    phase = phase_of(drive)
    names, counts = np.unique(phase, return_counts=True)
    assert dict(zip(names.tolist(), counts.tolist(), strict=True)) == {
        "drive": 580, "early_stop": 600, "late_stop": 320,
    }  # fmt: skip
    assert set(names) == set(PHASES)
    assert (phase[:20] == "late_stop").all()
    speed = speed_of(drive, rig)
    assert set(speed) == {0.0, 20.0}
    assert (speed[20:] == 20.0).all()


def test_cooling_is_the_hour_after_a_stop(small, driven):
    drive = driven(small, 4000, (10, 50))
    np.testing.assert_array_equal(np.flatnonzero(cooling(drive)), np.arange(50, 3650))
    assert stops(drive) == [50.0]
    assert stops(driven(small, 40, (10, 99))) == []
