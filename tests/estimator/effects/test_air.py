"""What still air takes more of what is warmer, at rest and while driving."""

from dataclasses import replace

import numpy as np
import pytest

from tests.estimator.effects.test_heat import REFERENCE, moving, watts


@pytest.mark.parametrize("n", [0.0, 0.2])
def test_still_air_takes_more_of_what_is_warmer_and_less_of_what_is_cooler(n, full, rig):
    """At rest of each place by its own warmth, which may be a third off; nothing under the nut and in the seats."""
    model = full.with_values({"still_air.h": 5.0, "free_convection.n": n})
    warm = np.array([[1.0], [4.0], [8.0]])
    still = replace(moving(rig, np.zeros(3)), rest_K=warm)
    places = warm * np.linspace(0.7, 1.4, rig.screw.cells)
    (link, put, back) = model.terms_of("free_convection", still, rig)
    hA = 5.0 * rig.screw.surface
    found = link.g * link.over * places - put.q * put.over - back.q * back.over
    exact = hA * still.bare * places * ((places / 4.0) ** n - 1.0)
    second = n * (1 + n) / 2 * (places / warm - 1.0) ** 2  # order, of what is off by so much of itself
    assert (np.abs(found - exact) <= 1.3 * second * hA * warm * (warm / 4.0) ** n + 1e-12).all()
    assert not found[still.bare == 0.0].any()


def test_air_that_the_screw_stirs_takes_more_of_it_as_a_whole(full, rig):
    """As much as in proportion at 4 K; of the cooler less, of the warmer more."""
    model = full.with_values({"still_air.h": 5.0, "free_convection.n": 0.2})
    rises, driven = np.array([[4.0], [8.0], [1.0], [0.0]]), moving(rig, np.full(4, REFERENCE))
    terms = list(model.terms_of("free_convection", replace(driven, motion=replace(driven.motion, warmth=rises)), rig))
    hA = 5.0 * rig.screw.surface * driven.bare[0].sum()
    taken = hA * rises[:, 0] * ((rises[:, 0] / 4.0) ** 0.2 - 1.0)
    np.testing.assert_allclose(watts(terms, "screw", 4), -taken, rtol=0, atol=1e-9)
    assert not np.any(terms[0].g)
