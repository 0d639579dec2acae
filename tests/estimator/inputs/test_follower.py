"""What may be followed: the formula that a generated file has and the function that a search uses are the same."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.battery.exercise import instants
from estimator.inputs.follower import COMING, MOTION, NAMES, PRODUCTS, all_followers, followers, known_followers
from estimator.rig import Signal
from estimator.rig_folder.rig_folder import load_rig
from tests.conftest import PAPER

EXAMPLES = sorted(path.parent for path in (PAPER.parent / "examples").glob("*/rig.toml"))
RIGS = [load_rig(folder) for folder in (PAPER, *EXAMPLES)]
SPINDLE = replace(  # moves, and has no screw that says what is fast
    RIGS[0], name="spindle", screw=None, nut=None, supports={}, inputs={"speed": Signal(unit="rpm"), "oil": Signal()}
)


@pytest.mark.parametrize("rig", [*RIGS, SPINDLE], ids=lambda rig: rig.name)
def test_formula_and_function_agree(rig):
    u = instants(rig)
    known = known_followers(rig)
    assert set(known) >= {"always", "time", "temperature", *rig.inputs}
    for name, follower in known.items():
        values = follower.values(u, rig)
        assert values.shape == (len(u), 1), name
        told = eval(follower.formula, {"np": np, "u": u, "rig": rig})
        np.testing.assert_allclose(np.broadcast_to(told, values.shape), values, rtol=1e-14, err_msg=name)
        assert (follower.name, bool(follower.words and follower.when)) == (name, True)
        assert np.abs(values).max() / follower.typical > 1e-3, name


def test_a_rig_that_moves_has_shapes_of_motion_and_its_temperatures():
    rig = RIGS[0]
    names = [follower.name for follower in followers(rig)]
    warm = [name for name, signal in rig.inputs.items() if signal.unit == "degC"]
    assert names == ["always", *(f.name for f in MOTION), "time", *warm, "temperature"]
    assert [f.name for f in all_followers(rig)] == [*names, *(f.name for f in (*PRODUCTS, *COMING))]
    assert set(NAMES) == {f.name for f in all_followers(rig)} - {*warm}
    assert {"speed", "position"} <= known_followers(rig).keys()


def test_one_that_never_moves_has_every_input_and_no_shape_of_motion():
    still = [rig for rig in RIGS if "speed" not in rig.inputs]
    assert still
    for rig in still:
        names = [follower.name for follower in followers(rig)]
        assert names == ["always", "time", *rig.inputs, "temperature"]
        assert not {follower.name for follower in (*MOTION, *PRODUCTS, *COMING)} & set(known_followers(rig))


def test_shapes_are_what_they_say():
    rig, u = RIGS[0], instants(RIGS[0])  # 300 s after a stop, then 1 and 2 s into a drive
    fading = np.exp(-np.array([300.0, 1.0, 2.0]) / 300.0)
    known = {name: follower.values(u, rig)[:, 0] for name, follower in known_followers(rig).items()}
    np.testing.assert_array_equal(known["drive"], [0, 1, 1])
    np.testing.assert_array_equal(known["rest"], [1, 0, 0])
    np.testing.assert_allclose(known["early_drive"], fading * [0, 1, 1])
    np.testing.assert_allclose(known["early_stop"], fading * [1, 0, 0])
    np.testing.assert_allclose(known["speed2"], np.array([0, 1 / 9, 1]) * u.unevenness[:, 0])
    np.testing.assert_allclose(known["speed_root"], np.array([0, 1 / np.sqrt(3), 1]) * u.unevenness[:, 0] ** -0.5)
    np.testing.assert_allclose(known["speed_fading"], fading ** (1 / 3) * [0, 1 / 3, 1])
    np.testing.assert_allclose(known["slow_stop"], fading ** (1 / 6) * [1, 0, 0])
    np.testing.assert_allclose(known["late_rest"], (1.0 - fading ** (1 / 3)) * [1, 0, 0])
    np.testing.assert_allclose(known["late_drive"], (1.0 - fading ** (1 / 3)) * [0, 1, 1])
    np.testing.assert_array_equal(known["temperature_speed"], known["speed"])
    np.testing.assert_array_equal(known["temperature_drive"], known["drive"])
    np.testing.assert_allclose(known["time"], np.array([900.0, 901.0, 902.0]) / 3600.0)
