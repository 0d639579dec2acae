"""Derivatives of one tick by many parameters, asked once: those that each gives alone, for all of the catalogue."""

import numpy as np
import pytest

from estimator.inputs.start import Start
from estimator.network.forcing import Forcing
from estimator.state.tangent import Moved, MovedApart


@pytest.fixture(scope="module")
def tick(paper, every, driven):
    """The model with every effect on the paper's rig, and a tick in mid-drive with all inputs on their way."""
    rig, _ = paper
    drive = driven(rig, 40, (10, 40), stroke=(0.0, 300.0))
    for k, name in enumerate(name for name in rig.inputs if name != "position"):
        drive.inputs[name][:] = 22 + (k + 1) / 40 * np.arange(40)
    forcing = Forcing(every, rig, Start(22.0, 0.0, {}))
    forcing.read(drive.rows(slice(30)))
    return forcing, forcing.read(drive.rows(slice(30, 31)))


def test_every_parameter_of_the_catalogue_in_a_row_of_its_own(tick):
    forcing, drive = tick
    model = forcing.model
    moved = [Moved(forcing, model, path) for path in model.values]
    moved = [each for each in moved if each.by_rows]
    heat, offset = MovedApart(forcing, moved).tick(drive)
    assert np.count_nonzero(np.any(heat, axis=1) | np.any(offset, axis=1)) > 30
    for k, each in enumerate(moved):
        alone = each.ticks(drive)
        np.testing.assert_allclose(heat[k], alone.heat[0], rtol=1e-12, atol=1e-15, err_msg=each.path)
        np.testing.assert_allclose(offset[k], alone.offset[0], rtol=1e-12, atol=1e-15, err_msg=each.path)
