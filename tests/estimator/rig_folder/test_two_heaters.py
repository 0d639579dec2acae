"""A rig without a screw, described by a folder: two heaters."""

from pathlib import Path

import numpy as np
import pytest

from estimator.rig_folder.model_toml import load_model
from tests.estimator.rig_folder.test_rig_folders import ballscrew, review

TWO = """
name = "two heaters"
tick_s = 10.0
[log]
time_column = "Time"
[channels]
T1 = { node = "left" }
T2 = { node = "right", column = "T2_F", scale = 0.5555555556, offset = -17.7777777778 }
[inputs]
Q1 = { unit = "%", hi = 100.0 }
ambient = { column = "room" }
"""

TWO_EFFECTS = '''
from estimator.effect import Effect, Param
from estimator.terms import Heat, Link, Store


class Heaters(Effect):
    """Two heaters warm each other and the room.

    C dT/dt = P Q - g (T - T_air) + g12 (T_other - T)
    """

    c = Param(10.0, "J/K", lo=1.0, hi=100.0)
    power = Param(0.005, "W/%", lo=0.0, hi=0.1, null=0.0)
    g = Param(0.02, "W/K", lo=0.0, hi=1.0)
    both = Param(0.02, "W/K", lo=0.0, hi=1.0)

    def terms(self, p, u, rig):
        for node in ("left", "right"):
            yield Store(node, p.c, noise=0.01)
            yield Link(node, "ambient", p.g)
        yield Link("left", "right", p.both)
        yield Heat("left", p.power * u["Q1"])
'''

TWO_MODEL = '[heaters]\nuse = "effects.py:Heaters"\nc = { value = 6.0, fixed = true }\n[thermometers]\nsd = 0.1\n'


@pytest.fixture
def two_heaters(tmp_path) -> Path:
    """Data by small steps of the equation: 6 J/K, 0.008 W/%, 0.05 W/K to the room, 0.03 W/K between them."""
    for name, text in (("rig.toml", TWO), ("effects.py", TWO_EFFECTS), ("model.toml", TWO_MODEL)):
        (tmp_path / name).write_text(text)
    dice, rows, a, b = np.random.default_rng(3), ["Time,Q1,T1,T2_F,room"], 21.0, 21.0
    for k in range(360):
        heat = 60.0 * (20 < k <= 200)
        for _ in range(100):
            a, b = (
                a + 0.1 / 6 * (0.008 * heat - 0.05 * (a - 21) + 0.03 * (b - a)),
                b + 0.1 / 6 * (-0.05 * (b - 21) + 0.03 * (a - b)),
            )
        read = np.array([a, b]) + dice.normal(0, 0.1, 2)
        rows.append(
            f"2026-03-01T12:{k // 6:02d}:{k % 6 * 10:02d}+00:00,{heat:g},{read[0]:.3f},{read[1] * 1.8 + 32:.3f},21"
        )
    (tmp_path / "run.csv").write_text("\n".join([*rows, ""]))
    return tmp_path


def test_two_heaters_without_a_screw_are_fitted_and_reviewed(two_heaters):
    ballscrew("fit", two_heaters, "-o", two_heaters / "better.toml", "--quiet")
    better = load_model(two_heaters / "better.toml")
    for path, true in {"heaters.power": 0.008, "heaters.g": 0.05, "heaters.both": 0.03}.items():
        assert better[path] == pytest.approx(true, rel=0.03)
    assert 1e-5 < better.values["heaters.power"].sd < 1e-3  # from one hour, six blocks
    assert better.values["thermometers.tau"].sd is None  # a body's thermometer has no lag: no influence
    found = review(two_heaters, "--model", two_heaters / "better.toml", "--save", two_heaters / "run.rrd")
    one = found["recordings"][0]
    assert one["temperature_K"]["one_step"] < 0.13
    assert one["temperature_K"]["open_loop"] < 0.13
    assert one["polyline"]["channels"] == 0
