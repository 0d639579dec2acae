"""Doubts about single signals: those that never come, that nobody named, in another unit, outside, or constant."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ballscrew.doubts.doubt import Case, Doubt
from ballscrew.new_rig import words
from ballscrew.new_rig.bus_log import BusLog
from ballscrew.new_rig.lab_table import LabTable
from ballscrew.new_rig.temperatures import unit_of
from drivers.frames import few
from drivers.lab.names import known_as, nearest_name
from estimator.errors import EffectError
from estimator.inputs.inputs import nothing
from estimator.network.check import checked_terms
from estimator.rig import RAD_S

_OUTSIDE = 0.02  # share of the readings outside lo ... hi that is no matter of single faults
_KELVIN = (220.0, 480.0)
_WARMED_K, _FEW = 1.0, 60  # by which the others moved, and readings, that tell a constant
FAHRENHEIT = "scale = 0.5555555556, offset = -17.7777777778"
_EVERY = (0.6, 1.7)  # ticks from one reading to the next


def never_came(case: Case) -> Iterator[Doubt]:
    """Messages of rig.toml that are not in the log, and columns that the CSV lacks."""
    lost: dict[str, list[str]] = {}
    for table, name, rule in case.signals():
        if isinstance(case.source, BusLog):
            for message in {signal.partition(".")[0] for signal in rule.signals} & {*case.source.never}:
                lost.setdefault(message, []).append(name)
        elif not case.of(name, rule) and not (table == "inputs" and _taken_by(case, name)):
            yield _no_column(case, table, name, rule.column or name, case.source)
    for message, names in lost.items():
        fix = "look at the DBC, the bus and the sender, or take it out of rig.toml"
        yield Doubt("rig.toml", f"message {message} never came: no {few(names)}", fix)
    closes = case.rig.log.closes
    if isinstance(case.source, BusLog) and closes in case.source.never:
        yield Doubt("rig.toml: log.closes", f"{closes} never came: the timer closes each tick", "name one that comes")


def _no_column(case: Case, table: str, name: str, column: str, source: LabTable) -> Doubt:
    """A column that is not there, or in which there is no number."""
    if any(known_as(one, column) for one in source.empty):
        return Doubt(
            case.place(table, name), f"column '{column}' holds no number", "look at that sensor and its logger"
        )
    near = nearest_name(column, [one.source for one in source.seen])
    hint = f"is it '{near}'? Say" if near else "say"
    return Doubt(case.place(table, name), f"no column '{column}'", f"{hint} its column")


def unnamed(case: Case) -> Iterator[Doubt]:
    """Temperatures in the log that rig.toml says nothing of."""
    named = {one.source for _, name, rule in case.signals() for one in case.of(name, rule)}
    free = [one for one in case.source.seen if one.source not in named and unit_of(one, case.source.seen)]
    if free:
        what = f"it names none of these temperatures: {few([one.source for one in free])}"
        yield Doubt("rig.toml", what, "add to [channels] or [inputs] what is of this rig")


def units(case: Case) -> Iterator[Doubt]:
    """Signals of a DBC in another unit than rig.toml's, where that says nothing of how to convert."""
    for table, name, rule in case.signals():
        for one in case.of(name, rule)[:1]:
            said = words.measure(one.unit)
            plain = rule.scale in (1.0, 1.0 / max(len(rule.signals), 1)) and rule.offset == 0.0
            if said is not None and plain and (factor := _factor(said, rule.unit)) != (1.0, 0.0):
                scale, offset = factor
                more = f", offset = {offset:g}" if offset else ""
                fix = 'unit = "K"' if said.unit == "K" else f"scale = {scale * rule.scale:.6g}{more}"
                yield Doubt(case.place(table, name), f"{one.source} is in {one.unit}, it says {rule.unit}", fix)


def _factor(said: words.Unit, unit: str) -> tuple[float, float]:
    """How a unit becomes rig.toml's; 1 and 0 where they are of two kinds, which is another matter."""
    if said.kind == "temperature" and unit == "degC":
        return said.scale, -273.15 if said.unit == "K" else said.offset
    if said.kind == "length" and unit in ("mm", "um"):
        return round(said.scale * (1000.0 if unit == "um" else 1.0), 9), 0.0
    if said.kind == "speed" and unit in RAD_S:
        return round(said.scale * RAD_S[said.unit] / RAD_S[unit], 6), 0.0
    return 1.0, 0.0


def outside(case: Case) -> Iterator[Doubt]:
    """Signals that are outside their range all the time or often."""
    for table, name, rule in case.signals():
        found = case.of(name, rule)
        count = case.recording.skipped.get(f"out of range {name}", 0)
        if not found or count <= _OUTSIDE * len(found[0].time):
            continue
        low, high = found[0].usual
        what = f"{count} of {len(found[0].time)} readings are outside {rule.lo:g} ... {rule.hi:g} {rule.unit}: "
        what += f"{found[0].source} has {low:.5g} ... {high:.5g}"
        is_kelvin = rule.unit == "degC" and _KELVIN[0] < low and high < _KELVIN[1]
        fix = 'in K? Then unit = "K"' if is_kelvin else "correct lo and hi, or scale and offset"
        yield Doubt(case.place(table, name), what, fix)


def constant(case: Case) -> Iterator[Doubt]:
    """Thermometers that never change while the others do."""
    columns = {name: case.recording.channels[:, case.rig.index(name)] for name in case.rig.thermometers}
    widths = {name: np.ptp(known) for name, one in columns.items() if len(known := one[np.isfinite(one)]) > _FEW}
    if len(widths) < 3 or np.median([*widths.values()]) < _WARMED_K:
        return
    for name, width in widths.items():
        if width == 0.0:
            value = columns[name][np.isfinite(columns[name])][0]
            yield Doubt(
                case.place("channels", name), f"always reads {value:g} degC", "look at that sensor and its signal"
            )


def ticks(case: Case) -> Iterator[Doubt]:
    """A tick that is not as long as the thermometers' scans are apart."""
    steps = [one.step_s for name in case.rig.thermometers for one in case.of(name, case.rig.channels[name])]
    step = float(np.median(steps)) if steps else case.rig.tick_s
    if np.isfinite(step) and not _EVERY[0] < step / case.rig.tick_s < _EVERY[1]:
        what = f"thermometers come each {step:.3g} s, tick_s is {case.rig.tick_s:g}"
        yield Doubt("rig.toml: tick_s", what, f"tick_s = {step:.2g}")


def not_measured(case: Case) -> Iterator[Doubt]:
    """Inputs that an effect of the model takes, and that are never read."""
    for name, column in case.recording.inputs.items():
        if np.isfinite(column).any():
            continue
        if effect := _taken_by(case, name):
            what = f"never read, and {effect} of the model takes it: it stays as the rig was at the start"
            yield Doubt(case.place("inputs", name), what, f"measure it, or leave {effect} out of model.toml")


def _taken_by(case: Case, name: str) -> str:
    """An effect of the model that cannot be without this input; "" where all can."""
    rig = replace(case.rig, inputs={other: rule for other, rule in case.rig.inputs.items() if other != name})
    try:
        checked_terms(case.model, nothing(rig), rig)
    except EffectError as error:
        return error.effect
    return ""


def noted(case: Case) -> Iterator[Doubt]:
    """What the reader had to mend of the clocks, or finds too hot to be in degC."""
    for note in case.recording.notes:
        if "clock" in note:
            fix = "it is mended here; one clock for all loggers, in UTC, needs no mending"
            yield Doubt(case.recording.name, note, fix)
        elif "degF" in note:
            yield Doubt("rig.toml: channels", note.partition("?")[0] + "?", f"then {FAHRENHEIT}")
