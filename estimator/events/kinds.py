"""An onset in words: what it is, where, since when, how much, and what to do."""

from dataclasses import replace

import numpy as np

from estimator.events.carriers import Carrier
from estimator.events.event import DRIVING, LOOSE, PART, Event
from estimator.events.onset import Onset
from estimator.events.readings import loose_words
from estimator.events.signature import Signature
from estimator.faults.sentences import place_of

MANY = 3.0  # times more, from which on a share is not told in %
AIR = ("still_air", "rotating_convection", "radiation")  # of the screw
HEATS = "something heats there since then: look for chips, a cover that rubs, what was switched on"
COOLS = "something cools there since then: look for coolant or air that reaches the screw"
HEATED = "something heated there: look for what was switched on meanwhile"
COOLED = "something cooled there: look for a lid or a door that was open, a fan, coolant"


def told(onset: Onset, seen: Signature) -> Event:
    """The event of an onset."""
    trial, step = seen.trial, onset.step
    event = Event(
        trial.recording.name, onset.since_s, onset.sd_s, step.kind, onset.until_s, trial.recording.began_s,
        gain=onset.gain,
    )  # fmt: skip
    if step.kind == LOOSE:
        event = replace(event, channel=step.channel, share=onset.size)
        rig = trial.rig
        what = f"{place_of(rig, rig.index(str(step.channel)))} {loose_words(-onset.size)}"
    elif step.carrier is None:
        event = replace(event, channel=step.channel, offset=onset.size)
        what = _reading(event, seen)
    else:
        event = _with_heat(event, step.carrier, onset, seen)
        what = _part(event, step.carrier.loses) if step.kind == PART else _heat(event)
    return replace(event, what=what)


def _with_heat(event: Event, carrier: Carrier, onset: Onset, seen: Signature) -> Event:
    time_s = seen.trial.rest.time_s
    during = (time_s >= onset.since_s) & (time_s < (onset.until_s or np.inf))
    each_W = float(np.mean(carrier.heat_W[during])) if during.any() else 0.0
    zone = carrier.zone
    return replace(
        event,
        from_mm=zone.from_mm if zone else None,
        to_mm=zone.to_mm if zone else None,
        name=None if zone and zone.node is None else carrier.name,
        heat_W=onset.size * each_W,
        sd_W=onset.sd * abs(each_W),
        share=None if zone else onset.size,
    )


def _heat(event: Event) -> str:
    heat = event.heat_W or 0.0
    place = f"in {event.name}" if event.name else f"at {((event.from_mm or 0.0) + (event.to_mm or 0.0)) / 2:.0f} mm"
    when = " while the screw turns" if event.kind == DRIVING else ""
    size, way = f"{_plain(abs(heat), 2)} W +- {_plain(event.sd_W or 0.0, 1)}", "little" if heat > 0 else "much"
    amount = f"{size} too {way} {place}{when}"
    if event.until_s is None:
        return f"the model has {amount}, for the rest of the run; {HEATS if heat > 0 else COOLS}"
    return f"the model has {amount}, and no more after that; {HEATED if heat > 0 else COOLED}"


def _part(event: Event, loses: bool) -> str:
    share = event.share or 0.0
    more = "more" if share > 0 else "less"
    percent = f"{_plain(abs(share), 2)} times" if share > MANY else f"{abs(100 * share):.0f} %"
    if event.name in AIR or loses:
        what = f"the screw loses {percent} {more} heat to the air ({event.name})"
        what = what if event.name in AIR else f"{event.name} takes {percent} {more} heat away"
        why = ("opened" if share > 0 else "closed") + (" meanwhile" if event.until_s else "")
        return f"{what}: a door or a lid was {why}"
    if event.name and event.name.endswith("friction"):
        what = event.name.removesuffix("_friction")
        return f"the {what} rubs {percent} {more} ({event.name}): greased, or its preload is another since then"
    return f"{event.name} does {percent} {more} than before: something was changed there"


def _reading(event: Event, seen: Signature) -> str:
    rig, offset = seen.trial.rig, event.offset or 0.0
    place, way = place_of(rig, rig.index(str(event.channel))), "high" if offset > 0 else "low"
    unit = "K" if event.channel in rig.thermometers else "um"
    return f"{place} reads {abs(offset):.2f} {unit} {way}, and no heat explains it: check how it sits"


def _plain(value: float, digits: int) -> str:
    """120, 5, 0.31: so many digits, and no powers of ten."""
    return f"{float(f'{value:.{digits}g}'):g}"
