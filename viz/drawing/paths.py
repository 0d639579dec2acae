"""Entity paths, names and colours: the one place where saved and live views get them from."""

import re

from estimator.rig import Rig

APPLICATION = "ballscrew"
TIMELINE = "time"

SUMMARY = "summary"
HEADLINE = "headline"
ACCURACY = "accuracy"

PROFILE = "profile"
ELONGATION = "elongation"
ERROR = "error"
SCREW = "screw"
AT_TABLE = "at_table"
MAPS = {  # of the innovations and of the model alone, and the colour bar of each
    "residual/innovation": "residual_bar/innovation",
    "residual/open_loop": "residual_bar/open_loop",
}
WHITENESS = "whiteness"
NIS = "nis"
TEMPERATURES = "channels/temperature"
INNOVATIONS = "channels/innovation"
DISPLACEMENT = "channels/displacement"
EVENTS = "events"
STATUS, BANNER = "status", "banner"
STATE = "state"
ESTIMATE, PUBLISHED, ALARMS = "estimate", "published", "alarms"  # below the state
FAULTS = "faults"  # likewise, in the order of their names
DRIVE, MODE, THERMOMETERS = (f"{STATE}/{name}" for name in ("drive", "mode", "thermometers"))
CHANNELS = "channel_state"  # of each channel
TABLE, STROKE = "table", "stroke"  # the error at the table over time, and over where the table may be
SURE, SURE_SD, SURE_BARS = "sure/error", "sure/sd", "sure/bars"
MOMENT = "moment"

BARS = "bars"
COMPARED = "compared"
PLANT = "plant"
SIDES = ("before", "after")
AUTOCORRELATION = "autocorrelation"

LEGEND_ENTRIES = 8  # a longer legend would scroll

Colour = tuple[int, int, int]

BACKGROUND: Colour = (16, 16, 18)
GRID: Colour = (62, 62, 66)
TEXT: Colour = (200, 200, 200)
FILTER: Colour = (90, 170, 255)
BAND: Colour = (40, 72, 128)
BAND_EDGE: Colour = (89, 143, 238)
OPEN_LOOP: Colour = (76, 189, 129)
SMOOTHED: Colour = (118, 79, 178)
POLYLINE: Colour = (182, 85, 7)
READING: Colour = (255, 234, 65)
DIAL: Colour = (116, 108, 102)
REFERENCE: Colour = (240, 240, 240)
SENT = OPEN_LOOP
MEASURED = READING
LEFT_OUT: Colour = (177, 72, 88)
VALID: Colour = (6, 52, 13)
UNSURE: Colour = (191, 146, 28)
NOTHING: Colour = (48, 39, 55)
LANES: dict[str, Colour] = {  # by how a state begins; what makes the estimate invalid is red, and nothing else is
    "valid": VALID, "sent as invalid": UNSURE, "sent": VALID,
    "driving": (167, 84, 16), "at rest": (99, 105, 120), "speed unknown": NOTHING,
    "init": NOTHING, "predict": (34, 85, 154), "update": (84, 143, 213), "coasting": UNSURE,
    "used": (79, 97, 59), "suspect": UNSURE, "muted": (59, 42, 120), "silent": (157, 136, 129),
    "not read": (39, 46, 46), "refused": (191, 90, 166), "no estimate yet": NOTHING, "not": NOTHING,
}  # fmt: skip
KINDS: dict[str, Colour] = {  # alarms of channels
    "silent": LANES["silent"], **dict.fromkeys(("may_drift", "bias", "nis", "scatter", "rejected"), UNSURE)
}  # fmt: skip
BEFORE = POLYLINE
AFTER = FILTER
COMPARED_AS = dict(zip(SIDES, (BEFORE, AFTER), strict=True))
CROSS_VALIDATED = OPEN_LOOP
HELD_OUT = READING
BOUND: Colour = (152, 152, 157)
METAL: Colour = (92, 94, 102)
NUT: Colour = (171, 180, 125)
RUNS: tuple[Colour, ...] = (  # in an order in which neighbours are apart for all eyes
    FILTER, POLYLINE, OPEN_LOOP, READING, (220, 110, 200), (255, 130, 130),
    (90, 220, 220), SMOOTHED, (190, 220, 90), REFERENCE, (205, 150, 100), (140, 160, 175),
)  # fmt: skip


def root(name: str) -> str:
    """Where the entities of a run begin: its name, in characters that a path needs no escapes for."""
    return re.sub(r"[^A-Za-z0-9_.-]+", "_", name)


def lane_colour(lane: str, text: str) -> Colour:
    """The colour of what a lane says: by the kind of alarm where it names channels, else by how it begins."""
    if f"/{FAULTS}/" in lane:
        return KINDS.get(lane.rpartition("/")[2], LANES["refused"])
    if lane.endswith(f"/{ALARMS}"):
        return LANES["suspect"]
    if lane == THERMOMETERS:
        used, _, rest = text.partition(" of ")
        return LANES["used"] if used == rest.split()[0] else LANES["suspect"]
    return next((colour for begin, colour in LANES.items() if text.startswith(begin)), LEFT_OUT)


def scaled(side: str, channel: str) -> str:
    """Where, below a run's root, the scaled innovations of a channel are: side "before" or "after"."""
    return f"scaled/{side}/{root(channel)}"


def compared(above: str, *parts: str) -> str:
    """Where views of two models on a run begin: `above` the run's root; parts such as what is shown and a channel."""
    return "/".join([above, COMPARED, *map(root, parts)])


def channel_names(rig: Rig, unit: str) -> list[str]:
    """Legend entries of the thermometers: name, place and unit."""
    named = [(name, rig.channels[name].at_mm) for name in rig.thermometers]
    return [f"{name} [{unit}]" if at is None else f"{name} at {at:g} mm [{unit}]" for name, at in named]


def thermometer_groups(rig: Rig, at: str = TEMPERATURES) -> dict[str, slice]:
    """Where below `at` the thermometers of each plot go: as few plots of equal size as leave every legend whole."""
    count = len(rig.thermometers)
    size = in_plot(count)
    return {f"{at}/{i + 1}": slice(first, min(first + size, count)) for i, first in enumerate(range(0, count, size))}


def in_plot(count: int) -> int:
    """How many of so many thermometers share a plot."""
    return max(1, -(-count // max(1, -(-count // LEGEND_ENTRIES))))
