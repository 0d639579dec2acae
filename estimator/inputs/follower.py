"""What heat or a reading may follow: motion, speed, time, or a temperature of the rig."""

from __future__ import annotations

import numpy as np

from estimator.inputs.inputs import Inputs
from estimator.record import Array
from estimator.rig import Rig

FADING_S = 300.0
HOUR = 3600.0
SHAPES = ("always", "drive", "rest", "early_drive", "early_stop", "speed", "speed2", "time")
TEMPERATURE = "temperature"


def followers(rig: Rig) -> tuple[str, ...]:
    """What something may follow on a rig: shapes of the motion, and every temperature that is an input."""
    own = [name for name, signal in rig.inputs.items() if signal.unit == "degC"]
    return (*SHAPES, *own) if "speed" in rig.inputs else ("always", "time", *rig.inputs)


def bodies(rig: Rig) -> tuple[str, ...]:
    """Bodies that thermometers read."""
    return tuple(sorted({channel.node for channel in rig.channels.values() if channel.node is not None}))


def following(name: str, u: Inputs, rig: Rig) -> Array:
    """What is followed, (ticks, 1), of the order of 1."""
    m = u.motion
    if name in SHAPES:
        speed = u.speed_law(rig.screw, 1.0) if rig.screw else u.omega
        shapes = {
            "always": np.ones_like(u.omega), "drive": m.turning, "rest": (1 - m.turning) * m.moved,
            "early_drive": m.turning * np.exp(-m.since_s / FADING_S),
            "early_stop": (1 - m.turning) * m.moved * np.exp(-m.since_s / FADING_S),
            "speed": speed, "speed2": speed**2 * u.unevenness, "time": m.time_s / HOUR,
        }  # fmt: skip
        return shapes[name]
    return u.rise(name)
