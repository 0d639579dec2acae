"""Entity paths, names and colours: the one place where saved and live views get them from."""

from __future__ import annotations

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
TABLE = "at_table"
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
STATUS = "status"
STATE = "state"
ESTIMATE, PUBLISHED, ALARMS = "estimate", "published", "alarms"  # below the state
FAULTS = "faults"  # likewise, in the order of their names
DRIVE, MODE, THERMOMETERS = (f"{STATE}/{name}" for name in ("drive", "mode", "thermometers"))
CHANNELS = "channel_state"  # of each channel
SURE, SURE_SD, SURE_BARS = "sure/error", "sure/sd", "sure/bars"
MOMENT = "moment"

BARS = "bars"
COMPARED = "compared"
SIDES = ("before", "after")
AUTOCORRELATION = "autocorrelation"

LEGEND_ENTRIES = 8  # a longer legend would scroll

Colour = tuple[int, int, int]

BACKGROUND: Colour = (16, 16, 18)
GRID: Colour = (62, 62, 66)
TEXT: Colour = (200, 200, 200)
FILTER: Colour = (90, 170, 255)
BAND: Colour = (40, 72, 128)
BAND_EDGE: Colour = (70, 130, 220)
OPEN_LOOP: Colour = (120, 210, 130)
SMOOTHED: Colour = (190, 150, 255)
POLYLINE: Colour = (240, 130, 60)
READING: Colour = (250, 220, 60)
DIAL: Colour = (150, 134, 60)
REFERENCE: Colour = (240, 240, 240)
MEASURED: Colour = (255, 180, 60)
LEFT_OUT: Colour = (225, 90, 90)
VALID: Colour = (60, 110, 75)
LANES: dict[str, Colour] = {  # by how a state begins; what makes the estimate invalid is red, and nothing else is
    "valid": VALID, "sent as invalid": (190, 150, 40), "sent": VALID,
    "driving": (196, 106, 40), "at rest": (58, 66, 78), "speed unknown": (110, 110, 116),
    "init": (110, 110, 116), "predict": (42, 74, 120), "update": (66, 128, 200), "coasting": (150, 116, 34),
    "used": (38, 84, 88), "suspect": (190, 150, 40), "muted": (104, 84, 160), "silent": (128, 128, 134),
    "not read": (74, 78, 84), "refused": (196, 76, 140), "no estimate yet": (110, 110, 116), "not": (110, 110, 116),
}  # fmt: skip
KINDS: dict[str, Colour] = {  # alarms of channels
    "silent": LANES["silent"], "may_drift": LANES["suspect"], "bias": (150, 116, 34), "nis": (150, 116, 34),
    "rejected": (150, 116, 34),
}  # fmt: skip
BEFORE: Colour = (240, 130, 60)
AFTER: Colour = (90, 170, 255)
COMPARED_AS = dict(zip(SIDES, (BEFORE, AFTER), strict=True))
CROSS_VALIDATED: Colour = (120, 210, 130)
HELD_OUT: Colour = (250, 220, 60)
BOUND: Colour = (150, 150, 155)
METAL: Colour = (92, 94, 102)
NUT: Colour = (200, 200, 80)
RUNS: tuple[Colour, ...] = (
    (90, 170, 255), (240, 130, 60), (120, 210, 130), (250, 220, 60), (220, 110, 200), (90, 220, 220),
    (255, 130, 130), (170, 150, 255), (190, 220, 90), (240, 240, 240), (205, 150, 100), (140, 160, 175),
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
    plots = -(-count // LEGEND_ENTRIES)
    size = -(-count // max(plots, 1))
    return {f"{at}/{i + 1}": slice(i * size, min((i + 1) * size, count)) for i in range(plots)}
