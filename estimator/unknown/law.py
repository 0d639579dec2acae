"""Laws: what heat or a reading follows, with the exponent or the time in it left open."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from estimator.effect import Param
from estimator.inputs.follower import (
    EARLY_DRIVE,
    EARLY_STOP,
    FADING_S,
    LATE_DRIVE,
    LATE_REST,
    LOSS_TURNING,
    PRODUCTS,
    RESTING,
    SLOW_STOP,
    SPEED,
    SPEED_ROOT,
    SPEED_SQUARED,
    Follower,
)

EXPONENT_SD = 1.0  # of what is tried: a half to two
TIME_SD = 1.0  # times what is tried
TURNING, SHARE = "u.motion.turning", "np.exp(-u.motion.since_s / p.tau)"
POWER = "u.speed_law(rig.the_screw(), p.n)"


@dataclass(frozen=True)
class Law:
    """What an effect multiplies by.

    when     something that follows it is there, for a person
    symbol   what an equation multiplies by;   formula: the same in Python, with p.NAME for each of its numbers
    numbers  exponent and time in it, by NAME, where the follower has them
    """

    when: str
    symbol: str
    formula: str
    numbers: Mapping[str, Param] = field(default_factory=dict, compare=False)


def law_of(follower: Follower) -> Law:
    """The law of a follower, its numbers where it has them."""
    for family, values in FAMILIES:
        if follower in values:
            numbers = {key: _number(key, value) for key, value in values[follower].items()}
            return Law(family.when, family.symbol, family.formula, numbers)
    return Law(follower.when, follower.symbol, follower.formula)


def _number(key: str, value: float) -> Param:
    if key == "n":
        return Param(value, "1", lo=0.1, hi=4.0, sd=EXPONENT_SD, source="1 is a constant torque, 2 what is viscous")
    return Param(value, "s", lo=10.0, hi=20000.0, sd=TIME_SD * value, source="how fast it fades")


_, _, SPEED_EARLY, SPEED_FADING = PRODUCTS
FAMILIES = (  # of one form each, and the numbers in it at which each follower stands
    (
        Law("in step with a power of the speed", " |omega / omega_ref|^n", POWER),
        {SPEED: {"n": 1.0}, SPEED_SQUARED: {"n": 2.0}, SPEED_ROOT: {"n": 0.5}},
    ),
    (
        Law("in step with the speed and the temperature", " |omega / omega_ref|^n", POWER),
        {LOSS_TURNING: {"n": 1.0}},
    ),
    (
        Law(
            "with a power of the speed, fading from the start of a drive on",
            " |omega / omega_ref|^n exp(-t / tau), t s after a drive began", f"{POWER} * {SHARE}",
        ),
        {SPEED_EARLY: {"n": 1.0, "tau": FADING_S}, SPEED_FADING: {"n": 1.0, "tau": 3 * FADING_S}},
    ),
    (
        Law(
            "from the start of a drive on, fading", " exp(-t / tau), t s after a drive began, else 0",
            f"{TURNING} * {SHARE}",
        ),
        {EARLY_DRIVE: {"tau": FADING_S}},
    ),
    (
        Law("after a stop, fading", " exp(-t / tau), t s after a stop, else 0", f"{RESTING} * {SHARE}"),
        {EARLY_STOP: {"tau": FADING_S}, SLOW_STOP: {"tau": 6 * FADING_S}},
    ),
    (
        Law(
            "ever more while the screw turns", " (1 - exp(-t / tau)), t s after a drive began, else 0",
            f"{TURNING} * (1.0 - {SHARE})",
        ),
        {LATE_DRIVE: {"tau": 3 * FADING_S}},
    ),
    (
        Law(
            "ever more while the screw stands after a drive", " (1 - exp(-t / tau)), t s after a stop, else 0",
            f"{RESTING} * (1.0 - {SHARE})",
        ),
        {LATE_REST: {"tau": 3 * FADING_S}},
    ),
)  # fmt: skip
