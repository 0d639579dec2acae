"""What is known before the first reading: a smooth profile at the level of the thermometers, and the bodies."""

import numpy as np
import pytest

from estimator.inputs.start import Start
from estimator.network.forcing import Forcing
from estimator.state.prior import BODY_SD_K, LEVEL_SD_K, UNKNOWN_BODY_SD_K, prior


@pytest.fixture(scope="module")
def forcing(full, rig):
    return Forcing(full, rig, Start(22.0, 0.4, {}))


def known(forcing, **inputs):
    return prior(forcing.start, forcing.terms, forcing.place, inputs)


def test_a_body_with_a_reading_starts_there_and_others_at_the_level(forcing):
    mean, cov = known(forcing, nut=23.5, anchor_bracket=np.nan)
    place = forcing.place
    assert mean[place.state("nut")] == 23.5
    assert cov[place.state("nut"), place.state("nut")] == BODY_SD_K**2
    for body in ("anchor_housing", "free_housing"):
        assert mean[place.state(body)] == 22.0
        assert cov[place.state(body), place.state(body)] == UNKNOWN_BODY_SD_K**2
    assert (mean[: len(place.knots_mm)] == 22.0).all()


def test_the_profile_is_uncertain_as_a_whole_and_smooth_along_the_screw(forcing):
    _, cov = known(forcing)
    knots = forcing.place.knots_mm
    screw = cov[: len(knots), : len(knots)]
    assert np.linalg.eigvalsh(cov).min() > 0
    assert screw[0, 0] == pytest.approx(LEVEL_SD_K**2 + 0.4**2 * (1 + 0.05**2), rel=1e-9)
    apart = screw[0, 0] + screw.diagonal() - 2 * screw[0]
    assert (np.diff(apart) > -1e-12).all()
    assert np.sqrt(apart[-1]) == pytest.approx(0.4 * np.sqrt(2), rel=0.01)
    assert np.sqrt(apart[1]) < 0.15


def test_the_screw_tells_nothing_of_the_bodies(forcing):
    _, cov = known(forcing, nut=23.5)
    screw = len(forcing.place.knots_mm)
    assert (cov[:screw, screw:] == 0).all()
