"""A box with a heater, a body in it that stores heat, and two coarse thermometers that lag, as a logger writes it."""

from pathlib import Path

import numpy as np

TICK_S, ROOM_C, STEP_C = 3.0, 22.0, 0.0625
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

    capacity = Param(450.0, "J/K", lo=10.0, hi=5000.0, sd=100.0, source="by a fit")
    power = Param(100.0, "W", lo=0.0, hi=300.0, null=0.0, fixed=True, source="its plate")
    g = Param(0.6, "W/K", lo=0.0, hi=10.0, sd=0.1, source="by a fit")
    noise = Param(3.0, "W/sqrt(Hz)", lo=1e-3, hi=100.0, fixed=True, source="draughts")

    def terms(self, p, u, rig):
        yield Store("air", p.capacity, p.noise)
        yield Heat("air", p.power * u["heater"])
        yield Link("air", "ambient", p.g)


class Inside(Effect):
    """What stands in the box stores heat too.

    C dT/dt = g (T_air - T)
    """

    capacity = Param(200.0, "J/K", lo=1.0, hi=5000.0, source="a guess")
    g = Param(1.0, "W/K", lo=0.0, hi=20.0, null=0.0, source="a guess")

    def terms(self, p, u, rig):
        yield Store("inside", p.capacity, 1e-6)
        yield Link("air", "inside", p.g)
'''


def box(folder: Path) -> Path:
    """Its rig folder, without recordings."""
    for name, text in (("rig.toml", RIG), ("model.toml", MODEL), ("effects.py", EFFECTS)):
        (folder / name).write_text(text)
    return folder


def run(
    path: Path, heater: np.ndarray, inside_J_K: float = 0.0, lid: range = range(0), jump_K: tuple[int, float] = (0, 0.0)
) -> Path:
    """A recording, a row a tick; thermometers lag by 40 and 60 s. The lid is open, or the first one jumps, at ticks."""
    air = inside = ROOM_C + 5.0
    read, rows = np.full(2, air), []
    for k, on in enumerate(heater):
        into = 0.2 * (air - inside) if inside_J_K else 0.0
        air += TICK_S * (100.0 * on - (6.0 if k in lid else 0.6) * (air - ROOM_C) - into) / 450.0
        inside += TICK_S * into / (inside_J_K or 1.0)
        read += TICK_S / np.array([40.0, 60.0]) * (air - read)
        off = np.array([jump_K[1] * (k >= jump_K[0]), 0.0])
        top, side = np.round((read + off) / STEP_C) * STEP_C
        rows.append(f"{TICK_S * k:g},{top:.3f},{side:.3f},{'True' if on else 'False'},{ROOM_C}")
    path.write_text("\n".join(["t_s,top,side,heater,room", *rows, ""]))
    return path
