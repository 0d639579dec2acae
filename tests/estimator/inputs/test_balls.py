"""Where balls carry, from where the whole nut was: against strokes whose every place is known."""

import numpy as np
import pytest

from estimator.inputs.balls import Balls, ByBalls


def strokes(rig, *parts, loads=(1.0, 1.0)):
    """Mean cover of strokes 113 mm long by parts of the nut, mm from its middle, which waits at one end; (1, cells)."""
    centre = np.concatenate([np.linspace(358.7, 471.2, 400), np.full(200, 471.2)])
    covers = [load * rig.screw.overlap(centre + a, centre + b).mean(axis=0) for load, (a, b) in zip(loads, parts)]
    return sum(covers)[None] * rig.nut.length_mm / sum(load * (b - a) for load, (a, b) in zip(loads, parts))


@pytest.mark.parametrize(
    ("balls", "parts", "loads"),
    [
        (Balls(0.0, 0.8, 0.0), [(-70.0, 70.0)], (1.0,)),
        (Balls(2.5, 0.96, 0.25), [(-81.5, -18.5), (23.5, 86.5)], (1.0, 1.0)),
        (Balls(2.5, 0.96, 0.25, 0.3), [(-81.5, -18.5), (23.5, 86.5)], (0.7, 1.3)),
        (Balls(-30.0, 0.4, 0.0), [(-65.0, 5.0)], (1.0,)),
    ],
)
def test_they_are_where_they_were(rig, balls, parts, loads):
    whole, true = strokes(rig, (-87.5, 87.5)), strokes(rig, *parts, loads=loads)
    found = np.asarray(ByBalls(whole, rig, balls))
    assert found.sum() == pytest.approx(whole.sum(), rel=1e-6)
    assert abs(whole - true).max() > 0.08
    even = np.ones(6) / 6.0  # what the states tell apart is wider than 24 mm
    np.testing.assert_allclose(np.convolve(found[0], even), np.convolve(true[0], even), atol=0.02)


def test_balls_all_along_a_nut_cover_what_it_covers(rig):
    whole = strokes(rig, (-87.5, 87.5))
    np.testing.assert_allclose(np.asarray(ByBalls(whole, rig, Balls(0.0, 1.0, 0.0))), whole, atol=1e-12)


def test_a_cover_on_the_states_is_that_of_its_cells(rig):
    rows = np.random.default_rng(1).standard_normal((rig.screw.cells, 3))
    by = ByBalls(strokes(rig, (-87.5, 87.5)), rig, Balls(1.0, 0.9 + 1e-30j, 0.2))
    assert by.is_complex
    assert ByBalls(by.cover + 0j, rig, Balls(1.0, 0.9, 0.2)).is_complex  # a nut that was elsewhere, by a complex step
    q = np.arange(len(by.cover))[:, None] - 1.0  # nothing, at one of the ticks
    for some in (q, np.full((1, 1), 2.0), q * (1.0 + 1e-30j)):
        np.testing.assert_allclose(by.carried(some, rows), some * (np.asarray(by) @ rows), rtol=1e-9)
        assert abs(by.carried(some, rows).imag).max() > 0.0
