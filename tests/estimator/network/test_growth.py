"""Growth of a screw that one bearing holds, or two, against a chain of springs solved as such."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from estimator.effects.held import HeldEnds
from estimator.network.growth import Growth
from estimator.rig import Rig
from estimator.screw import Screw, Support
from estimator.terms import Expand, Hold

STIFF = st.floats(10.0, 1e5)


def rig_of(anchor_mm: float, free_mm: float) -> Rig:
    screw = Screw(-50.0, 1030.0, 40.0, 17.0, span_from_mm=44.5, span_to_mm=980.0, cells=108)
    supports = {"anchor": Support(anchor_mm, 40.0), "free": Support(free_mm, 30.0)}
    return replace(Rig("bench", 1.0, {}, {}), screw=screw, supports=supports)


def hold(rig: Rig, **values: float) -> Hold:
    (term,) = HeldEnds().terms(HeldEnds().namespace(values), None, rig)
    return term


def chained(rig: Rig, springs: dict[float, float], rise: np.ndarray) -> dict[float, float]:
    """Where the edges of the cells go, um: bars in a row, each E A / h, and springs to the machine at some edges."""
    screw = rig.the_screw()
    bar = 206e9 * screw.area / screw.length * 1e-6
    n = screw.cells + 1
    stiffness, force = np.zeros((n, n)), np.zeros(n)
    for cell in range(screw.cells):
        stiffness[cell : cell + 2, cell : cell + 2] += bar * np.array([[1, -1], [-1, 1]])
        pushes = bar * screw.expansion * rise[cell] * screw.length * 1e6
        force[cell : cell + 2] += (-pushes, pushes)
    for place, spring in springs.items():
        stiffness[int(np.argmin(abs(screw.edges_mm - place)))][int(np.argmin(abs(screw.edges_mm - place)))] += spring
    return dict(zip(np.round(screw.edges_mm, 6), np.linalg.solve(stiffness, force), strict=True))


@given(STIFF, STIFF, st.booleans(), st.integers(0, 1000))
def test_it_is_a_chain_of_springs(k_anchor, k_free, turned, seed):
    anchor, free = (890.0, 70.0)[:: -1 if turned else 1]
    rig = rig_of(anchor, free)
    rise = np.random.default_rng(seed).uniform(-5.0, 20.0, rig.the_screw().cells)
    went = chained(rig, {anchor: k_anchor, free: k_free}, rise)
    growth = Growth([hold(rig, k_anchor=k_anchor, k_free=k_free)], rig)
    for lo, hi in ((-50.0, 1030.0), (40.0, 980.0), (300.0, 520.0), (910.0, 1000.0), (0.0, 60.0)):
        assert growth.between(lo, hi) @ rise == pytest.approx(went[hi] - went[lo], abs=1e-6)
    for nut in (100.0, 480.0, 880.0, 30.0, 950.0):
        away = np.sign(nut - anchor) * went[nut]
        assert growth.away(anchor, nut) @ rise == pytest.approx(away, abs=1e-6)


def test_a_bearing_that_slides_holds_nothing_and_two_rigid_ones_all():
    rig = rig_of(890.0, 70.0)
    free, rise = Growth([], rig), np.linspace(2.0, 9.0, rig.the_screw().cells)
    slides = Growth([hold(rig, k_free=0.0)], rig)
    np.testing.assert_array_equal(slides.span(), free.span())
    np.testing.assert_array_equal(slides.away(890.0, 400.0), free.away(890.0, 400.0))
    rigid = Growth([hold(rig, k_anchor=1e12, k_free=1e12)], rig)
    assert rigid.between(70.0, 890.0) @ rise == pytest.approx(0.0, abs=1e-5)
    assert abs(rigid.away(890.0, 480.0) @ rise) > 3.0  # the middle moves all the same


def test_the_coefficient_scales_what_is_held_too():
    rig, rise = rig_of(890.0, 70.0), np.ones(108)
    held = hold(rig)
    more = Growth([held, Expand(0.04)], rig)
    assert more.span() @ rise == pytest.approx(1.04 * (Growth([held], rig).span() @ rise))
    assert more.away(890.0, 300.0) @ rise == pytest.approx(1.04 * (Growth([held], rig).away(890.0, 300.0) @ rise))
