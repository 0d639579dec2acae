"""--channels, --no-displacement and --mute: what the filter is not to use, and when."""

import re
from collections.abc import Sequence

import numpy as np

from estimator.errors import SetupError, nearest
from estimator.inputs.phase import stops
from estimator.record import Recording
from estimator.rig import Rig
from estimator.state.gate import Mute

UNITS_S = {"h": 3600.0, "min": 60.0, "s": 1.0}


def seconds(text: str) -> float:
    """A time such as 2h, 90min, 45s or plain seconds; anything else is a ValueError."""
    unit = next((unit for unit in UNITS_S if text.strip().endswith(unit)), "")
    return float(text.strip().removesuffix(unit)) * UNITS_S.get(unit, 1.0)


def chosen_thermometers(text: str | None, rig: Rig) -> list[str] | None:
    """`2,4,12` or `T02,T04` as channel names; None where nothing was chosen."""
    if text is None:
        return None
    return [_thermometer(word.strip(), rig) for word in text.split(",")]


def _thermometer(word: str, rig: Rig) -> str:
    name = _numbered(word, rig)
    if name in rig.thermometers:
        return name
    raise SetupError(f"--channels {word}: no such thermometer; {nearest(word, rig.thermometers)}, or 1 ... "
                     f"{len(rig.thermometers)}")  # fmt: skip


def _numbered(word: str, rig: Rig) -> str:
    """The name of a thermometer that is given by its number; any other word as it is."""
    if word.isdigit() and 1 <= int(word) <= len(rig.thermometers):
        return rig.thermometers[int(word) - 1]
    return word


def muted(
    recording: Recording, rig: Rig, thermometers: Sequence[str] | None, no_displacement: bool, spans: Sequence[str]
) -> Mute:
    """What not to fuse in this recording, as the filter asks for it: by time, (m,) bool."""
    always = never_fused(rig, thermometers, no_displacement)
    parsed = [_span(span, recording, rig) for span in spans]

    def mute(time_s: float) -> np.ndarray:
        now = always.copy()
        for channels, begin, end in parsed:
            if begin <= time_s <= end:
                now |= channels
        return now

    return mute


def never_fused(rig: Rig, thermometers: Sequence[str] | None, no_displacement: bool) -> np.ndarray:
    """Channels not to fuse at any time, (m,) bool: thermometers that were not chosen, and the displacement."""
    kept = rig.thermometers if thermometers is None else thermometers
    return ~np.isin(rig.names, list(kept)) & (rig.is_thermometer | no_displacement)


def _span(text: str, recording: Recording, rig: Rig) -> tuple[np.ndarray, float, float]:
    name, colon, times = text.partition(":")
    if not colon or not times:
        raise SetupError(f"--mute {text}: write NAME:FROM, NAME:FROM-TO or NAME:FROM+TIME, like telemeter:stop1+60min")
    begin, to, end = re.fullmatch(r"([^-+]*)([-+]?)(.*)", times, re.DOTALL).groups()  # type: ignore[union-attr]
    since, until = _time(begin, text, recording), np.inf
    if to:
        until = _time(end, text, recording) if to == "-" else since + _long(end, text)
    if since > (last := float(recording.time_s[-1])):
        raise SetupError(
            f"--mute {text}: {recording.name} ends at {last - float(recording.time_s[0]):.0f} s, before that"
        )
    if until <= since:
        raise SetupError(f"--mute {text}: it ends ({end}) before it begins ({begin})")
    return _named(_numbered(name, rig), rig), since, until


def _named(name: str, rig: Rig) -> np.ndarray:
    if name == "telemeter":
        return rig.is_thermometer
    if name == "displacement":
        return ~rig.is_thermometer
    return np.arange(len(rig.names)) == rig.index(name)


def _long(word: str, text: str) -> float:
    try:
        return seconds(word)
    except ValueError:
        raise SetupError(f"--mute {text}: '{word}' is no time; write 2h, 90min, 45s or seconds") from None


def _time(word: str, text: str, recording: Recording) -> float:
    """Seconds from the first sample, or the end of the n-th drive."""
    if word.startswith("stop") and word[4:].isdigit():
        known = stops(recording)
        if not 1 <= int(word[4:]) <= len(known):
            raise SetupError(f"--mute {text}: {recording.name} has {len(known)} stops")
        return known[int(word[4:]) - 1]
    try:
        return float(word) + float(recording.time_s[0])
    except ValueError:
        raise SetupError(f"--mute {text}: '{word}' is neither seconds nor stop1, stop2, ...") from None
