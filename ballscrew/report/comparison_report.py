"""Models against recordings, beside each other: tables and JSON."""

from __future__ import annotations

from collections.abc import Sequence

from ballscrew.report.errors import HORIZONS, KEYS, by_horizon, cells, number
from ballscrew.report.page import Section
from estimator.accuracy.compare import Comparison
from estimator.accuracy.noise_floor import Error
from estimator.inputs.phase import PHASES


def sections(found: Sequence[Comparison]) -> list[Section]:
    """The tables: by horizon, by phase and speed, by channel."""
    head = ["", *(cell for one in found for cell in (f"{one.name}, K", "um"))]
    rows = [[title, *cells([one.whole[key] for one in found])] for key, title in HORIZONS.items()]
    rows.append(["sensors alone", *cells([one.floor for one in found])])
    if any(one.held_out for one in found):
        rows.append(["held out: model alone", *cells([_held_out(one) for one in found])])
    said = [*_reference(found[0]), *(f"{one.name}: {warning}" for one in found for warning in one.warnings)]
    parts = {PHASES[phase]: [one.by_phase[phase] for one in found] for phase in PHASES}
    parts |= {f"at {speed:g} m/min": [one.by_speed[speed] for one in found] for speed in found[0].by_speed}
    alone = [[title, *cells([errors["open_loop"] for errors in some])] for title, some in parts.items()]
    return [
        Section("how far ahead", said, [["error, rms", *head[1:]], *rows]),
        Section("by the model alone (open loop)", (), [head, *alone]),
        _by_channel(found),
    ]


def _reference(found: Comparison) -> list[str]:
    """What the elongation was compared with; nothing where it was with nothing."""
    parts, rest = ["the truth"] if found.truths else [], found.recordings - found.truths
    if rest and "displacement" in found.by_channel:
        read = "the displacement readings, and at rest the direct reading joined at the stop"
        parts.append(f"{read} ({rest} of {found.recordings} recordings)" if found.truths else read)
    return [f"elongation compared with {'; '.join(parts)}"] if parts else []


def _by_channel(found: Sequence[Comparison]) -> Section:
    alone = len(found) == 1
    horizons = list(HORIZONS) if alone else ["open_loop"]
    head = ["1 tick", "10 min", "alone"] if alone else [one.name for one in found]
    title = "channels, rms in K or um" + ("" if alone else ", by the model alone")
    rows = [
        [name, *(number(one.by_channel[name][key], 3) for one in found for key in horizons)]
        for name in found[0].by_channel
    ]
    return Section(title, (), [["channel", *head], *rows])


def _held_out(found: Comparison) -> Error:
    return found.held_out["open_loop"] if found.held_out else Error(float("nan"), float("nan"))


def as_json(found: Comparison) -> dict[str, object]:
    """One model's errors for programs."""
    by_channel = found.by_channel.items()
    return {
        "name": found.name,
        **by_horizon(found.whole),
        "held_out": vars(_held_out(found)) if found.held_out else None,
        "by_channel": {name: {KEYS[key]: error for key, error in errors.items()} for name, errors in by_channel},
        "by_phase": {phase: by_horizon(errors) for phase, errors in found.by_phase.items()},
        "by_speed_m_min": {f"{speed:g}": by_horizon(errors) for speed, errors in found.by_speed.items()},
        "noise_floor": vars(found.floor),
        "reference": {"truth": found.truths, "readings": found.recordings - found.truths},
        "warnings": list(found.warnings),
    }
