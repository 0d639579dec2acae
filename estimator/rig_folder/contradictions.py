"""What cannot be in a rig, though each of its numbers may: parts that need another, places outside, wrong units."""

from collections.abc import Iterator

import numpy as np

from estimator.errors import nearest
from estimator.network import mesh
from estimator.rig import Rig
from estimator.rig_folder.bounds import COLDEST_C, TIME_UNITS, UNITS
from estimator.screw import Bed, Screw

THINNEST_MM, SHORTEST_MM = 0.1, 1.0
CLOSEST_MM = 1e-3
LEAST_SCALE, LEAST_EXPANSION = 1e-12, 1e-9
MOST_STATES = 200  # of the screw: the work grows with their cube
LOOSE = 3e3  # condition of the shapes of places that so few cells can hardly tell apart


def contradictions(rig: Rig) -> Iterator[str]:
    """What cannot be, one sentence each."""
    yield from _signals(rig)
    yield from _channels(rig)
    yield from _log(rig)
    yield from _off_the_screw(rig)
    if rig.nut:
        yield from _nut(rig)
    if rig.bed:
        yield from _bed(rig, rig.bed)
    if rig.screw:
        yield from _states(rig)
    elif rig.zero_C is not None:
        yield "zero_C is where the growth of the screw is zero, but there is no [screw]; leave it out"
    if rig.zero_sd_K and rig.zero_C is None:
        yield "zero_sd_K is how well zero_C is known, but there is no zero_C; say it, or leave both out"


def _signals(rig: Rig) -> Iterator[str]:
    for table, signals in (("channels", rig.channels), ("inputs", rig.inputs)):
        for name, signal in signals.items():
            if not signal.lo < signal.hi:
                yield f"{name}: lo = {signal.lo:g} is not below hi = {signal.hi:g}"
            if abs(signal.scale) < LEAST_SCALE:
                yield f"{table}.{name}.scale is {signal.scale:g}: every reading would be the same; correct it"
            if signal.unit == "degC" and signal.hi <= COLDEST_C:
                yield f"{table}.{name}: hi = {signal.hi:g} degC is below absolute zero"
    for name, known in UNITS.items():
        if name in rig.inputs and (unit := rig.inputs[name].unit) not in known:
            yield f"inputs.{name}.unit: '{unit}' is no unit of it; use {' or '.join(known)}"
    if both := sorted({*rig.channels} & {*rig.inputs}):
        yield f"inputs.{both[0]}: a channel has that name already; rename one of them"


def _channels(rig: Rig) -> Iterator[str]:
    if not rig.thermometers:
        yield "channels: no thermometer among them; give at least one its at_mm or node"
    for name, channel in rig.channels.items():
        if channel.at_mm is not None and channel.node is not None:
            yield f"channels.{name} has both at_mm and node; a thermometer is in one place"
        if channel.node in ("screw", "start", "elongation"):
            yield f"channels.{name}.node: '{channel.node}' is no body; a thermometer on the screw has at_mm"
        unit, what = ("degC", "thermometer") if channel.is_thermometer else ("um", "length")
        if channel.unit != unit:
            hint = (
                "; scale and offset convert" if channel.is_thermometer else ", or at_mm or node if it is a thermometer"
            )
            yield f"channels.{name}.unit: '{channel.unit}' is no unit of a {what}; use {unit}{hint}"
    yield from _twice(rig)
    for name in rig.subset_7:
        if name not in rig.thermometers:
            yield f"subset_7: no thermometer '{name}'; {nearest(name, rig.thermometers)}"
    if len({*rig.subset_7}) < len(rig.subset_7):
        yield "subset_7: a thermometer is named twice"


def _twice(rig: Rig) -> Iterator[str]:
    """Channels that would show the same."""
    read: dict[str, str] = {}
    for name, channel in rig.channels.items():
        for source in (*channel.signals, *((f"column {channel.column}",) if channel.column else ())):
            if source in read:
                yield f"channels.{name}: {source} is read by channels.{read[source]} already; correct one of them"
            read[source] = name


def _log(rig: Rig) -> Iterator[str]:
    for key in ("scan_state", "scan_crc", "fault_mask"):
        if getattr(rig.log, key) is not None and not rig.log.scan:
            yield f"log.{key} is of a scan, but there is no log.scan; name the messages that make one"
    csv = rig.log.csv
    if csv.separator not in (None, "tab", "space") and len(csv.separator) > 1:
        yield f'log.csv.separator: \'{csv.separator}\' is none; give one character, "tab" or "space"'
    if csv.decimal not in (None, ".", ","):
        yield f'log.csv.decimal: \'{csv.decimal}\' is no decimal mark; use "." or ","'
    if csv.time_unit not in (None, *TIME_UNITS):
        yield f"log.csv.time_unit: {nearest(csv.time_unit, TIME_UNITS)}"


def _off_the_screw(rig: Rig) -> Iterator[str]:
    screw = rig.screw
    places = {f"channels.{name}.at_mm": c.at_mm for name, c in rig.channels.items() if c.at_mm is not None}
    places |= {f"supports.{name}.at_mm": support.at_mm for name, support in rig.supports.items()}
    if screw is None:
        for key in places:
            yield f"{key} is a place on the screw, but there is no [screw]"
        return
    if not screw.from_mm + SHORTEST_MM <= screw.to_mm:
        yield f"screw: from_mm must be below to_mm: {screw.from_mm:g} ... {screw.to_mm:g} mm"
    if not screw.bore_mm + THINNEST_MM <= screw.outer_mm:
        yield f"screw: bore_mm must be below outer_mm: {screw.bore_mm:g} and {screw.outer_mm:g} mm"
    if abs(screw.expansion) < LEAST_EXPANSION:
        yield f"screw.expansion is {screw.expansion:g}: nothing would grow; steel has 12e-6 1/K"
    places |= {f"screw.knots_mm: {place:g}": place for place in screw.knots_mm}
    places |= dict(zip(("screw.span_from_mm", "screw.span_to_mm"), screw.span_mm, strict=True))
    for key, place in places.items():
        if not screw.from_mm <= place <= screw.to_mm:
            yield f"{key} = {place:g} is outside the screw, {screw.from_mm:g} ... {screw.to_mm:g} mm"
    if not screw.span_mm[0] + SHORTEST_MM <= screw.span_mm[1]:
        yield "screw: span_from_mm must be below span_to_mm: {:g} ... {:g} mm".format(*screw.span_mm)


def _bed(rig: Rig, bed: Bed) -> Iterator[str]:
    if rig.nut is None or "anchor" not in rig.supports:
        yield "[bed] is what the error at the table is told against: it needs [nut] and supports.anchor"
    elif bed.input not in rig.inputs:
        yield f"bed.input: no input '{bed.input}'; {nearest(bed.input, rig.inputs)}"
    elif rig.inputs[bed.input].unit != "degC":
        yield f"bed.input: '{bed.input}' is in {rig.inputs[bed.input].unit}; name a thermometer"


def _nut(rig: Rig) -> Iterator[str]:
    assert rig.nut
    if missing := [name for name in ("position", "speed") if name not in rig.inputs]:
        yield f"[nut] needs the input '{missing[0]}'; add it to [inputs] or leave the nut out"
    elif abs(rig.nut.direction) != 1:
        yield f"nut.direction is {rig.nut.direction:g}, must be 1 or -1: which way its centre moves"
    elif rig.screw:
        yield from _beside(rig, rig.screw)
    else:
        yield "[nut] needs [screw]; add it or leave the nut out"


def _beside(rig: Rig, screw: Screw) -> Iterator[str]:
    """A nut that never gets to the screw."""
    assert rig.nut
    position = rig.inputs["position"]
    lo, hi = np.sort(rig.nut.centre(np.array([position.lo, position.hi]))) + np.array([-0.5, 0.5]) * rig.nut.length_mm
    if lo >= screw.to_mm or hi <= screw.from_mm:
        yield (
            f"nut: at no position from {position.lo:g} to {position.hi:g} mm is it on the screw: it covers {lo:g} ... "
            f"{hi:g} mm, the screw {screw.from_mm:g} ... {screw.to_mm:g} mm; correct nut.centre_mm"
        )


def _states(rig: Rig) -> Iterator[str]:
    """Places of the states that are too many, or too close for so few cells."""
    assert rig.screw
    knots, cells = mesh.knots(rig), rig.screw.cells
    if not 2 <= len(knots) <= MOST_STATES:
        yield f"screw: {len(knots)} places of states along it, must be 2 ... {MOST_STATES}; choose them with knots_mm"
        return
    closest = float(np.diff(knots).min())
    if closest < CLOSEST_MM or len(knots) > cells or np.linalg.cond(mesh.shapes(knots, rig.screw.x_mm)) > LOOSE:
        yield (
            f"screw: cells = {cells} cannot tell {len(knots)} places of thermometers, bearings and knots_mm apart, "
            f"{closest:g} mm the closest; take more cells, or places that are further apart or the same"
        )
