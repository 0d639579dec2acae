"""What the effects that act on readings alone say: thermometers one by one and together, the probes' length."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.battery.exercise import instants, open_loop, run as exercise
from estimator.effects import CATALOGUE
from estimator.errors import SetupError
from estimator.inputs.start import Start
from estimator.network.forcing import Forcing
from tests.conftest import terms_of


def readings(model, rig):
    return Forcing(model, rig, Start(22.0, 0.0, dict.fromkeys(rig.inputs, 0.0))).readings


def added(model, name: str, rig, **values):
    """What an effect adds to the readings of the model alone, (K, m), and those readings, (K, m)."""
    drive = exercise(rig)
    more = (model + CATALOGUE[name]).with_values({f"{name}.{key}": value for key, value in values.items()})
    plain = open_loop(model, rig, drive)
    return open_loop(more, rig, drive) - plain, plain


def test_sensor_lag_adds_to_the_thermometers_own(full, rig):
    usual = readings(full, rig).tau
    slower = readings((full + CATALOGUE["sensor_lag"]).with_values({"sensor_lag.tau": 12.0}), rig).tau
    np.testing.assert_allclose(slower - usual, [12.0] * 15 + [0.0])
    one = full.with_values({"thermometers.tau": 20.0})
    both = (full + CATALOGUE["sensor_lag"]).with_values({"sensor_lag.tau": 12.0})
    drive = exercise(rig)
    np.testing.assert_allclose(open_loop(one, rig, drive), open_loop(both, rig, drive), rtol=0, atol=1e-9)


def test_an_offset_is_one_channel_s_from_the_first_motion_on(full, rig):
    more, _ = added(full, "channel_offset", rig, offset=0.7, channel=4.0)
    expected = np.zeros_like(more)
    expected[5:, 3] = 0.7
    np.testing.assert_allclose(more, expected, rtol=0, atol=1e-12)


def test_a_gain_is_one_channel_s_in_proportion_to_its_rise(full, rig):
    more, plain = added(full, "channel_gain", rig, gain=0.1, channel=9.0)
    board = full["thermometers.board"]
    assert board == 0
    np.testing.assert_allclose(more[:, 8], 0.1 * (plain[:, 8] - 22.0), rtol=0, atol=1e-9)
    assert more[-1, 8] > 0.1
    assert (np.delete(more, 8, axis=1) == 0).all()


def test_a_gain_of_a_thermometer_in_a_body(full, rig):
    inside = replace(rig, channels={**rig.channels, "T09": replace(rig.channels["T09"], at_mm=None, node="nut")})
    more, plain = added(full, "channel_gain", inside, gain=0.1, channel=9.0)
    np.testing.assert_allclose(more[:, 8], 0.1 * (plain[:, 8] - 22.0), rtol=0, atol=1e-9)


def test_a_support_yields_with_its_bearing_s_temperature(full, rig):
    more, _ = added(full, "support_yield", rig, rate=0.8)
    anchor = next(i for i, name in enumerate(rig.names) if rig.channels[name].at_mm == rig.supports["anchor"].at_mm)
    exact = full.with_values({"thermometers.tau": 0.0, "thermometers.bore": 0.0})
    rise = open_loop(exact, rig, exercise(rig))[:, anchor] - 22.0
    np.testing.assert_allclose(more[:, 15], 0.8 * rise, rtol=0, atol=1e-9)
    assert rise.max() > 0.5
    assert (more[:, :15] == 0).all()


@pytest.mark.parametrize(
    ("effect", "key", "name", "sign", "channels"),
    [
        ("board_drift", "drift", "board", 1.0, slice(0, 15)),
        ("probe_expansion", "rate", "probe", 1.0, slice(15, 16)),
        ("bar_expansion", "rate", "bar", -1.0, slice(15, 16)),
    ],
)
def test_readings_drift_with_an_input_s_rise(effect, key, name, sign, channels, full, rig):
    more, _ = added(full, effect, rig, **{key: 0.2})
    rise = exercise(rig).inputs[name] - exercise(rig).inputs[name][0]
    expected = np.zeros_like(more)
    expected[:, channels] = sign * 0.2 * rise[:, None]
    np.testing.assert_allclose(more, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("effect", "name"), [("board_drift", "board"), ("probe_expansion", "probe")])
def test_an_effect_of_an_input_asks_for_it(effect, name, rig):
    u = instants(rig)
    lacking = replace(u, values={key: column for key, column in u.values.items() if key != name})
    with pytest.raises(SetupError, match=rf"{effect}: needs the input '{name}'"):
        terms_of(effect, rig, lacking)
