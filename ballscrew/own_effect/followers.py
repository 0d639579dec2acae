"""What a new effect may follow: motion, speed, temperature, or an input of the rig."""

from __future__ import annotations

import json
from dataclasses import dataclass

from estimator.rig import Rig

TEMPERATURE = "temperature"


@dataclass(frozen=True)
class Follower:
    """What an effect follows: in words, in the equation, in Python; the unit of 1 of it, and how large it gets."""

    when: str
    symbol: str = ""
    factor: str = ""
    unit: str = ""
    typical: float = 1.0


FOLLOWERS = {
    "always": Follower("always"),
    "drive": Follower("while the screw turns", " while the screw turns, else 0", "u.motion.turning"),
    "early_drive": Follower(
        "in the first minutes of a drive",
        " exp(-t / 300 s), t s after a drive began, else 0",
        "u.motion.turning * np.exp(-u.motion.since_s / 300.0)",
    ),
    "rest": Follower("while the screw stands", " while the screw stands, else 0", "1.0 - u.motion.turning"),
    "early_stop": Follower(
        "in the first minutes of a stop",
        " exp(-t / 300 s), t s after a stop, else 0",
        "(1.0 - u.motion.turning) * u.motion.moved * np.exp(-u.motion.since_s / 300.0)",
    ),
    "speed": Follower(
        "in step with the speed", " |omega / omega_ref|", "rig.the_screw().relative_speed(u.omega)"
    ),
    "speed2": Follower(
        "in step with the square of the speed",
        " (omega / omega_ref)^2",
        "u.speed_law(rig.the_screw(), 2.0)",
    ),
    "time": Follower("in step with the time", " t / 1 h", "u.motion.time_s / 3600.0"),
    TEMPERATURE: Follower("in step with the temperature"),
}  # fmt: skip

MOTION = ("drive", "early_drive", "rest", "early_stop", "speed", "speed2")  # which take a speed


def follower_of(word: str, rig: Rig) -> Follower:
    """What a word means: one of FOLLOWERS, or an input of the rig, of which an effect follows the rise."""
    if word in FOLLOWERS:
        return FOLLOWERS[word]
    signal = rig.inputs[word]
    unit = "K" if signal.unit == "degC" else signal.unit
    typical = 5.0 if signal.unit == "degC" else (signal.hi - signal.lo) / 10
    factor = f"u.rise({json.dumps(word)})"
    return Follower(f"in step with {word}", f" ({word} - {word}(0))", factor, unit, typical)
