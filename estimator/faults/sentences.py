"""What was not used of recordings, in plain sentences: broken channels, zeros that became others, readings refused."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from estimator.faults.fault import Fault, Spell, Suspicion
from estimator.faults.use import NOT_MEASURED, ChannelUse, Jump, Use
from estimator.rig import Rig
from estimator.screw import Bed

FEW = 3  # channels that are named one by one
GAPS = 0.01  # of the ticks, in which a thermometer is missing more often than the others: said


def sentences(uses: Iterable[Use], rig: Rig) -> list[str]:
    """What a person should know of the readings that were not used, recording by recording."""
    return [f"{use.name}: {told}" for use in uses for told in _told(use, rig)]


def place_of(rig: Rig, i: int | np.intp) -> str:
    """A channel with its place: T06 at 559 mm."""
    name = rig.names[i]
    at = rig.channels[name].at_mm
    return name if at is None else f"{name} at {at:g} mm"


def _told(use: Use, rig: Rig) -> Iterator[str]:
    if use.again:
        yield f"begun again at {use.begun_s:.0f} s: what was read before were no temperatures"
    for name in use.never:
        slow = rig.inputs[name].unit == "degC"
        held = "the screw's temperature at the start" if slow else "0"
        doing = "" if slow else "; if it was not 0, thermometers may be accused of what it does"
        yield f"input {name} was never read: {held} stands for it{doing}"
        if rig.bed and rig.bed.input == name:
            yield bed_unread(rig.bed)
    for one in use.suspects:
        yield broken(one, rig)
    yield from (suspected(one, each, rig) for one in use.channels for each in one.suspicions)
    for name, spells in use.inputs.items():
        held = "its last value is held, check that sensor" if spells[0].fault == Fault.JUMPED else "check that sensor"
        yield f"input {name} {_how(spells[0].fault, spells)}: {held}"
    for name, from_s in use.silent.items():
        yield f"input {name} is not read since {from_s:.0f} s: its last value is held"
    for from_s, why in use.travel[:FEW]:
        yield f"{why}, at {from_s:.0f} s: heat may be in the wrong place, the error at the table is not to be trusted"
    if use.too_slow:
        yield use.too_slow
    for jump in use.jumps:
        yield _jumped(jump, rig)
    if counts := list(_counts(use, rig)):
        yield f"readings not used: {'; '.join(counts)}"


def bed_unread(bed: Bed) -> str:
    """Why nothing is known of the error at the table, and what to do."""
    return (
        f"the error at the table is not known, for nothing has been read of {bed.input}, the temperature of the bed: "
        f"correct its signal at inputs.{bed.input} in rig.toml, or leave out [bed]"
    )


def broken(one: ChannelUse, rig: Rig) -> str:
    """T06 at 559 mm is stuck, since 1800 s: left out, check that sensor."""
    doubt = {
        Fault.DRIFTING: "; if it is well, heat is missing there",
        Fault.APART: "; if it is well, the model's expansion is wrong",
    }.get(one.suspect, "")
    return (
        f"{place_of(rig, rig.index(one.channel))} {_how(one.suspect, one.spells)}: left out, check that sensor{doubt}"
    )


def suspected(one: ChannelUse, suspicion: Suspicion, rig: Rig) -> str:
    """T06 at 559 mm may have drifted by +0.12 K, from 1800 s on: it is used, with a zero that is not known."""
    to = f"to {suspicion.to_s:.0f} s" if np.isfinite(suspicion.to_s) else "on"
    return (
        f"{place_of(rig, rig.index(one.channel))} may have drifted by {suspicion.most_K:+.2f} K, "
        f"from {suspicion.from_s:.0f} s {to}: it is used, with a zero that is not known by as much"
    )


def _how(fault: Fault, spells: Sequence[Spell]) -> str:
    """Is stuck, since 1800 s; was loose, three times from 30 s on, the last until 700 s."""
    first, last = spells[0], spells[-1]
    lasts = not np.isfinite(last.to_s)
    head = fault.said if lasts else PAST[fault]
    if len(spells) > 1:
        until = "still at the end" if lasts else f"the last until {last.to_s:.0f} s"
        return f"{head}, {len(spells)} times from {first.from_s:.0f} s on, {until}"
    return f"{head}, since {first.from_s:.0f} s" if lasts else f"{head} from {first.from_s:.0f} s to {last.to_s:.0f} s"


PAST = {
    Fault.STUCK: "was stuck",
    Fault.JUMPED: "had jumped",
    Fault.LOOSE: "was loose",
    Fault.DRIFTING: "drifted away from its neighbours",
    Fault.OFF: "was off from the start",
    Fault.APART: "grew otherwise than the thermometers say",
}


def _jumped(jump: Jump, rig: Rig) -> str:
    """All thermometers jumped together by +1.02 K at 1800 s."""
    sizes, unit = list(jump.sizes.values()), rig.channels[next(iter(jump.sizes))].unit
    unit = "K" if unit == "degC" else unit
    low, high = min(sizes), max(sizes)
    by = f"{low:+.2f}" if high - low < 0.01 else f"{low:+.2f} .. {high:+.2f}"
    what = "their zeros are others" if len(sizes) > 1 else "its zero is another one"
    return f"{named(jump.sizes, rig)} jumped by {by} {unit} at {jump.time_s:.0f} s: {what} from then on"


def named(channels: Iterable[str], rig: Rig) -> str:
    """T01, T02; T01 ... T12 (12 channels); all thermometers."""
    names = list(channels)
    if names == list(rig.thermometers) and len(names) > FEW:
        return "all thermometers"
    return ", ".join(names) if len(names) <= FEW else f"{names[0]} ... {names[-1]} ({len(names)} channels)"


def _counts(use: Use, rig: Rig) -> Iterator[str]:
    """T06: 5759 x stuck, 10 x jumped; all thermometers, T01 ... T15: 3 x power-on value. Alike ones together."""
    alike: dict[str, list[str]] = {}
    for one in use.channels:
        if reasons := _reasons(one, use, rig):
            alike.setdefault(", ".join(f"{count} x {reason}" for reason, count in reasons), []).append(one.channel)
    for told, channels in alike.items():
        who = named(channels, rig)
        yield f"{who}{'' if channels[0] in who else f', {channels[0]} ... {channels[-1]}'}: {told}"


def _reasons(one: ChannelUse, use: Use, rig: Rig) -> list[tuple[str, int]]:
    """Why a channel was not used, and how often; gaps only where it has more of them than other thermometers."""
    heat = set(rig.thermometers)
    least = min((other.why.get(NOT_MEASURED, 0) for other in use.channels if other.channel in heat), default=0)
    gaps = one.why.get(NOT_MEASURED, 0) - least if one.channel in heat else 0
    said = gaps > GAPS * (one.taken + gaps)
    return [(reason, count) for reason, count in one.why.items() if reason != NOT_MEASURED or said]
