"""The law that a model knows is the law that the rig has."""

from itertools import count

import numpy as np
import pytest

from benchmarks.hidden.true_law import LAWS, true_law
from drivers.virtual_rig.machine.drawn import DRAWN, PLACES_MM, WATTS, WIDTHS_MM, Drawn, drawn
from drivers.virtual_rig.machine.geometry import OMEGA_20
from drivers.virtual_rig.machine.motion import Pace
from estimator.inputs.inputs import no_inputs
from estimator.inputs.motion import Motion
from estimator.rig import Rig


def of_kind(kind: str) -> Drawn:
    return next(one for seed in count() if (one := drawn(seed)).kind == kind)


@pytest.mark.parametrize("kind", WATTS)
def test_a_drawn_law_is_the_same_on_the_rig_and_in_a_model(rig: Rig, kind: str):
    one = of_kind(kind)
    for speed, seconds in ((1.0, 40.0), (0.3, 400.0), (0.0, 40.0), (0.0, 900.0)):
        since = (0.0, seconds) if speed else (seconds, 0.0)  # the stop, the start
        pace = Pace(np.full(20, speed * OMEGA_20), float(speed > 0), *since, fading_s=1.0)
        u = no_inputs(rig, np.array([[speed * OMEGA_20]]), np.zeros((1, rig.the_screw().cells)))
        moves = np.array([[float(speed > 0)]])
        motion = Motion(np.array([[1000.0]]), moves, np.array([[seconds]]), np.ones((1, 1)))
        object.__setattr__(u, "motion", motion)
        assert LAWS[kind](one, u, rig) == pytest.approx(one.factor(pace), rel=1e-3, abs=1e-9), (speed, seconds)
    assert true_law(one).name == DRAWN


def test_what_is_drawn_lies_in_its_ranges_and_is_of_every_kind():
    shapes = [drawn(seed) for seed in range(60)]
    assert {one.kind for one in shapes} == {*WATTS}
    assert all(WATTS[one.kind][0] <= abs(one.watts) <= WATTS[one.kind][1] for one in shapes)
    assert all(PLACES_MM[0] <= one.place_mm <= PLACES_MM[1] for one in shapes)
    assert all(WIDTHS_MM[0] <= one.width_mm <= WIDTHS_MM[1] for one in shapes)
    assert {np.sign(one.watts) for one in shapes} == {-1.0, 1.0}
