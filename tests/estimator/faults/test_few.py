"""Two coarse thermometers in a box whose model knows neither their lag nor its lid: none of them is broken."""

from pathlib import Path

import numpy as np
import pytest

from drivers.recordings import read_recording
from estimator.accuracy.review import review
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig

TICK_S, ROOM_C, STEP_C = 3.0, 22.0, 0.0625
LID, JUMP = 900, 1100  # ticks
RIG = """
name = "box"
tick_s = 3.0
[log]
time_column = "t_s"
[channels]
top = { node = "air" }
side = { node = "air" }
[inputs]
heater = { unit = "1", lo = 0.0, hi = 1.0 }
ambient = { column = "room" }
"""
MODEL = '[box]\nuse = "effects.py:Box"\n[thermometers]\nsd = 0.05\n'
EFFECTS = '''
from estimator.effect import Effect, Param
from estimator.terms import Heat, Link, Store


class Box(Effect):
    """The air of a box: a heater warms it, the walls cool it.

    C dT/dt = P heater - g (T - T_room)
    """

    capacity = Param(450.0, "J/K", lo=10.0, hi=5000.0, source="by a fit")
    power = Param(100.0, "W", lo=0.0, hi=300.0, null=0.0, source="its plate")
    g = Param(0.6, "W/K", lo=0.0, hi=10.0, source="by a fit")
    noise = Param(3.0, "W/sqrt(Hz)", lo=1e-3, hi=100.0, fixed=True, source="draughts")

    def terms(self, p, u, rig):
        yield Store("air", p.capacity, p.noise)
        yield Heat("air", p.power * u["heater"])
        yield Link("air", "ambient", p.g)
'''


def box(folder: Path, jump_K: float) -> Path:
    """A recording: its thermometers lag by 40 and 60 s and read in sixteenths; the lid is open for two minutes."""
    heater = (np.arange(1500) % 400 < 60).astype(float) * (np.arange(1500) > 20)
    air, read, rows = ROOM_C + 5.0, np.full(2, ROOM_C + 5.0), []
    for k, on in enumerate(heater):
        g = 6.0 if LID <= k < LID + 40 else 0.6
        air += TICK_S * (100.0 * on - g * (air - ROOM_C)) / 450.0
        read += TICK_S / np.array([40.0, 60.0]) * (air - read)
        off = np.array([jump_K * (k >= JUMP), 0.0])
        top, side = np.round((read + off) / STEP_C) * STEP_C
        rows.append(f"{TICK_S * k},{top:.3f},{side:.3f},{'True' if on else 'False'},{ROOM_C}")
    for name, text in (("rig.toml", RIG), ("model.toml", MODEL), ("effects.py", EFFECTS)):
        (folder / name).write_text(text)
    (folder / "run.csv").write_text("\n".join(["t_s,top,side,heater,room", *rows, ""]))
    return folder


@pytest.mark.parametrize(("jump_K", "broken"), [(0.0, ["", ""]), (8.0, ["jumped", ""])])
def test_what_a_model_lacks_is_no_fault_of_few_thermometers_and_what_jumps_is(tmp_path, jump_K, broken):
    """Heat that comes a minute late, readings that stand still within a step, a lid: all others are said to be well."""
    rig = load_rig(box(tmp_path, jump_K))
    recording = read_recording(tmp_path / "run.csv", rig)
    assert {*recording.inputs["heater"]} == {0.0, 1.0}
    use = review(recording, rig, load_model(tmp_path / "model.toml")).use
    assert [one.spells[-1].fault.word if one.spells else "" for one in use.channels] == broken
    assert not use.again
    assert not use.jumps
