"""The strokes and speeds of the experiments, by name: pattern, dash, speed in m/min."""

import difflib

from drivers.virtual_rig.machine.motion import Stroke

# Table positions between which the table moves, mm
PATTERNS = {"FS": (0.0, 400.0), "CS": (130.0, 243.0), "ES": (202.0, 315.0)}
SPEEDS = ("20", "10", "5", "2.5")
EXPERIMENTS = tuple(f"{pattern}-{speed}" for pattern in PATTERNS for speed in SPEEDS)

# m/min; beyond the fastest, the short strokes hold no constant speed long enough for a peak to be held
SLOWEST, FASTEST = 1.0, 25.0


def stroke(name: str) -> Stroke:
    """The stroke of an experiment; any speed between 1 and 25 m/min may follow the pattern."""
    pattern, _, text = name.partition("-")
    try:
        (low, high), speed = PATTERNS[pattern], float(text)
    except (KeyError, ValueError):
        near = difflib.get_close_matches(name.upper(), EXPERIMENTS, n=1, cutoff=0.0)[0]
        raise ValueError(f"unknown experiment {name!r}; did you mean {near!r}?") from None
    if not SLOWEST <= speed <= FASTEST:
        raise ValueError(f"experiment {name!r}: the speed must lie between {SLOWEST:g} and {FASTEST:g} m/min")
    return Stroke(low, high, speed * 1000.0 / 60.0)
