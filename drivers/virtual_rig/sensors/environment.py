"""Thermometers around the screw: air, base, brackets, nut, probes, bar - each with a small fixed offset."""

from typing import NamedTuple

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.sensors.telemeter import quantised

OFFSET_K = 0.05
NOISE_K = 0.02


class Environment(NamedTuple):
    """degC, each (n,), in the order in which they are sent"""

    ambient: np.ndarray
    base: np.ndarray
    bracket_anchor: np.ndarray
    bracket_free: np.ndarray
    nut: np.ndarray
    probe: np.ndarray
    bar: np.ndarray


def read(around: Environment, seed: int, run: str) -> Environment:
    """What the thermometers show of the true temperatures; the offsets stay the same from run to run."""
    offsets = dice(seed, "environment").uniform(-OFFSET_K, OFFSET_K, len(around))
    draw = dice(seed, run, "environment")
    noise = NOISE_K * draw.standard_normal((len(around), len(around.ambient)))
    return Environment(*(quantised(t + o + e) for t, o, e in zip(around, offsets, noise, strict=True)))
