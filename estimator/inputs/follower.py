"""What heat or a reading may follow: motion, speed, time, an input of the rig, or the temperature where it acts."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from estimator.inputs.inputs import Inputs
from estimator.inputs.phase import turns
from estimator.record import Array
from estimator.rig import AT_REST, Rig

FADING_S = 300.0
HOUR = 3600.0


@dataclass(frozen=True)
class Follower:
    """One thing to follow over time.

    name     as command lines and results have it
    words    what is followed, for a person
    when     when something that follows it is there, for a person
    symbol   what an equation multiplies by
    formula  what an effect multiplies by, in Python: (ticks, 1), of the order of 1
    values   the same as a function
    unit     of a value; "" for a number
    typical  how large a value gets, in this unit
    phase    of the machine, outside which it is zero; None where there is no one such
    loss     heat that follows it is lost to the air: P times this, times (T_air - T) there
    """

    name: str
    words: str
    when: str
    symbol: str
    formula: str
    values: Callable[[Inputs, Rig], Array] = field(compare=False)
    unit: str = ""
    typical: float = 1.0
    phase: str | None = None
    loss: bool = False


def _fading(u: Inputs) -> Array:
    """1 at the last start or stop, and less from there on."""
    return np.asarray(np.exp(-u.motion.since_s / FADING_S))


FADING = f"np.exp(-u.motion.since_s / {FADING_S})"
RESTING = "(1.0 - u.motion.turning) * u.motion.moved"
ALWAYS = Follower("always", "nothing: it is always there", "always", "", "1.0", lambda u, rig: np.ones_like(u.omega))
DRIVE = Follower(
    "drive", "the drive", "while the screw turns", " while the screw turns, else 0",
    "u.motion.turning", lambda u, rig: u.motion.turning, phase="drive",
)  # fmt: skip
REST = Follower(
    "rest", "the rest", "while the screw stands after a drive", " while the screw stands after a drive, else 0",
    RESTING, lambda u, rig: (1.0 - u.motion.turning) * u.motion.moved,
)  # fmt: skip
EARLY_DRIVE = Follower(
    "early_drive", "the first minutes of a drive", "in the first minutes of a drive",
    " exp(-t / 300 s), t s after a drive began, else 0",
    f"u.motion.turning * {FADING}", lambda u, rig: u.motion.turning * _fading(u), phase="drive",
)  # fmt: skip
EARLY_STOP = Follower(
    "early_stop", "the first minutes after a stop", "in the first minutes of a stop",
    " exp(-t / 300 s), t s after a stop, else 0",
    f"{RESTING} * {FADING}", lambda u, rig: REST.values(u, rig) * _fading(u), phase="early_stop",
)  # fmt: skip
SPEED = Follower(
    "speed", "the speed", "in step with the speed", " |omega / omega_ref|",
    "rig.the_screw().relative_speed(u.omega)", lambda u, rig: rig.the_screw().relative_speed(u.omega), phase="drive",
)  # fmt: skip
SPEED_SQUARED = Follower(
    "speed2", "the speed squared", "in step with the square of the speed", " (omega / omega_ref)^2",
    "u.speed_law(rig.the_screw(), 2.0)", lambda u, rig: u.speed_law(rig.the_screw(), 2.0), phase="drive",
)  # fmt: skip
TIME = Follower(
    "time", "the time", "in step with the time", " t / 1 h",
    f"u.motion.time_s / {HOUR}", lambda u, rig: u.motion.time_s / HOUR,
)  # fmt: skip
TEMPERATURE = Follower(  # where something acts: part of the state, and nothing that is known beforehand
    "temperature", "the temperature there", "in step with the temperature", "",
    "1.0", lambda u, rig: np.ones_like(u.omega), loss=True,
)  # fmt: skip
LOSS_TURNING = replace(
    SPEED, name="temperature_speed", words="the temperature there, times the speed",
    when="in step with the temperature and the speed", loss=True,
)  # fmt: skip
LOSS_DRIVE = replace(  # by the speed of a regime: of a conductance no other motion is known
    DRIVE, name="temperature_drive", words="the temperature there, while the screw turns",
    when="in step with the temperature while the screw turns", formula=f"1.0 * (u.omega > {AT_REST})",
    values=lambda u, rig: 1.0 * turns(u.omega), loss=True,
)  # fmt: skip
RATE = replace(TEMPERATURE, name="rate", words="how fast the temperature there changes", when="while that changes")


def _fading_speed(fading_s: float, name: str, words: str) -> Follower:
    """The speed times what fades from the start of a drive on."""
    return Follower(
        name, f"the speed, fading in the {words} of a drive", f"with the speed, in the {words} of a drive",
        f" |omega / omega_ref| exp(-t / {fading_s:.0f} s), t s after a drive began",
        f"rig.the_screw().relative_speed(u.omega) * np.exp(-u.motion.since_s / {fading_s})",
        lambda u, rig: rig.the_screw().relative_speed(u.omega) * np.exp(-u.motion.since_s / fading_s), phase="drive",
    )  # fmt: skip


SPEED_ROOT = Follower(
    "speed_root", "the root of the speed", "in step with the root of the speed", " (omega / omega_ref)^0.5",
    "u.speed_law(rig.the_screw(), 0.5)", lambda u, rig: u.speed_law(rig.the_screw(), 0.5), phase="drive",
)  # fmt: skip
SLOW_STOP = Follower(
    "slow_stop", "the first hour after a stop", "in the first hour of a stop",
    f" exp(-t / {6 * FADING_S:.0f} s), t s after a stop, else 0",
    f"{RESTING} * np.exp(-u.motion.since_s / {6 * FADING_S})",
    lambda u, rig: REST.values(u, rig) * np.exp(-u.motion.since_s / (6 * FADING_S)),
)  # fmt: skip
LATE_REST = Follower(
    "late_rest", "the rest, coming in its first quarter of an hour", "ever more while the screw stands after a drive",
    f" (1 - exp(-t / {3 * FADING_S:.0f} s)), t s after a stop, else 0",
    f"{RESTING} * (1.0 - np.exp(-u.motion.since_s / {3 * FADING_S}))",
    lambda u, rig: REST.values(u, rig) * (1.0 - np.exp(-u.motion.since_s / (3 * FADING_S))),
)  # fmt: skip
LATE_DRIVE = Follower(
    "late_drive", "the drive, coming in its first quarter of an hour", "ever more while the screw turns",
    f" (1 - exp(-t / {3 * FADING_S:.0f} s)), t s after a drive began, else 0",
    f"u.motion.turning * (1.0 - np.exp(-u.motion.since_s / {3 * FADING_S}))",
    lambda u, rig: u.motion.turning * (1.0 - np.exp(-u.motion.since_s / (3 * FADING_S))), phase="drive",
)  # fmt: skip
MOTION = (DRIVE, REST, EARLY_DRIVE, EARLY_STOP, SPEED, SPEED_SQUARED)  # which take a speed
PRODUCTS = (
    SPEED_ROOT,
    SLOW_STOP,
    _fading_speed(FADING_S, "speed_early_drive", "first minutes"),
    _fading_speed(3 * FADING_S, "speed_fading", "first quarter of an hour"),
)
LOSSES = (LOSS_TURNING, LOSS_DRIVE)  # heat to the air, which a reading cannot follow
COMING = (LATE_DRIVE, LATE_REST, *LOSSES)  # asked only where a search has found something
NAMES = tuple(follower.name for follower in (ALWAYS, *MOTION, TIME, TEMPERATURE, *PRODUCTS, *COMING))


def followers(rig: Rig) -> tuple[Follower, ...]:
    """What a search tries on a rig: shapes of the motion, and inputs; last the temperature where something acts.

    On a rig that moves only temperatures are tried of the inputs, on one that never moves all.
    """
    motion = _motion(rig)
    inputs = [name for name, signal in rig.inputs.items() if not motion or signal.unit == "degC"]
    return (ALWAYS, *motion, TIME, *(_input(name, rig) for name in inputs), TEMPERATURE)


def all_followers(rig: Rig) -> tuple[Follower, ...]:
    """What a search tries, and behind it what is asked where it has found something: other laws, products, losses."""
    more = products(rig)
    return (*followers(rig), *more, *(COMING if more else ()))


def products(rig: Rig) -> tuple[Follower, ...]:
    """Other powers of the speed, slower decays, and speeds that fade; on a rig whose screw says what is fast."""
    return PRODUCTS if rig.screw is not None and "speed" in rig.inputs else ()


def known_followers(rig: Rig) -> dict[str, Follower]:
    """All that can be followed on a rig, by name: what a search tries or asks, and every other input."""
    return {name: _input(name, rig) for name in rig.inputs} | {f.name: f for f in all_followers(rig)}


def _motion(rig: Rig) -> tuple[Follower, ...]:
    """Shapes of the motion; where no screw says what is fast, speeds are in rad/s."""
    if "speed" not in rig.inputs:
        return ()
    if rig.screw is not None:
        return MOTION
    speed = replace(SPEED, symbol=" omega", formula="u.omega", values=lambda u, rig: u.omega)
    squared = replace(
        SPEED_SQUARED, symbol=" omega^2", formula="u.omega**2 * u.unevenness",
        values=lambda u, rig: u.omega**2 * u.unevenness,
    )  # fmt: skip
    return (*MOTION[:-2], replace(speed, unit="rad/s", typical=100.0), replace(squared, unit="rad2/s2", typical=1e4))


def _input(name: str, rig: Rig) -> Follower:
    """The change of an input since the start."""
    signal = rig.inputs[name]
    unit, typical = ("K", 5.0) if signal.unit == "degC" else (signal.unit, (signal.hi - signal.lo) / 10)
    return Follower(
        name, f"the input '{name}'", f"in step with {name}", f" ({name} - {name}(0))",
        f"u.rise({json.dumps(name)})", lambda u, rig: u.rise(name), unit, typical,
    )  # fmt: skip
