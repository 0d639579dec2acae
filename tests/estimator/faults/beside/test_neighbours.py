"""Which thermometers that drift may be right: heat moves neighbours to one side, a sensor's fault moves it alone."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.faults.beside.neighbours import may_be_heat


@pytest.mark.parametrize(
    ("sides", "right"),
    [
        ({}, []),
        ({"T2": +1}, []),
        ({"T2": +5, "T3": +1}, ["T2", "T3"]),
        ({"T2": +9, "T3": -1}, ["T2", "T3"]),
        ({"T2": +1, "T3": -1}, []),
        ({"T4": -1}, ["T4"]),
        ({"T4": -1, "T3": +1}, []),
        ({"T1": +1, "T2": +1, "T4": -1}, ["T1", "T2", "T4"]),
    ],
    ids=[
        "none",
        "one alone",
        "two beside each other",
        "one of them hardly",
        "swapped",
        "the last one",
        "the last two swapped",
        "both ends",
    ],
)
def test_neighbours_that_drift_to_one_side_may_be_heat(small, sides, right):
    side = np.array([sides.get(name, 0.0) for name in small.names])
    assert [name for name, heat in zip(small.names, may_be_heat(side, small), strict=True) if heat] == right


def test_where_the_thermometers_have_no_places_nothing_can_be_said(small):
    bodies = {name: replace(channel, at_mm=None) for name, channel in small.channels.items()}
    assert not may_be_heat(np.ones(len(small.names)), replace(small, channels=bodies)).any()
