"""Models against recordings, beside each other: tables and JSON."""

from collections.abc import Sequence

from ballscrew.report.sections import HORIZONS, KEYS, Section, by_horizon, cells, number
from ballscrew.report.use_report import recordings_json
from estimator.accuracy.compare import Comparison
from estimator.accuracy.noise_floor import Error
from estimator.inputs.phase import PHASES


def sections(comparisons: Sequence[Comparison], machine: Sequence[str] = ()) -> list[Section]:
    """The tables: by horizon, by phase and speed, by channel; `machine`: what is said of whose models they are."""
    head = ["", *(cell for one in comparisons for cell in (f"{one.name}, K", "um"))]
    rows = [[title, *cells([one.whole[key] for one in comparisons])] for key, title in HORIZONS.items()]
    rows.append(["sensors alone", *cells([one.floor for one in comparisons])])
    if any(one.held_out for one in comparisons):
        rows.append(["held out: model alone", *cells([_held_out(one) for one in comparisons])])
    said = [*_reference(comparisons[0]), *(f"{one.name}: {warning}" for one in comparisons for warning in one.warnings)]
    said += machine
    parts = {PHASES[phase]: [one.by_phase[phase] for one in comparisons] for phase in PHASES}
    parts |= {f"at {speed:g} m/min": [one.by_speed[speed] for one in comparisons] for speed in comparisons[0].by_speed}
    alone = [[title, *cells([errors["open_loop"] for errors in some])] for title, some in parts.items()]
    return [
        Section("how far ahead", said, [["error, rms", *head[1:]], *rows]),
        Section("by the model alone (open loop)", (), [head, *alone]),
        _by_channel(comparisons),
    ]


def _reference(comparison: Comparison) -> list[str]:
    """What the elongation was compared with; nothing where it was with nothing."""
    parts, rest = ["the truth"] if comparison.truths else [], comparison.recordings - comparison.truths
    if rest and "displacement" in comparison.by_channel:
        read = "the displacement readings, and at rest the direct reading joined at the stop"
        parts.append(f"{read} ({rest} of {comparison.recordings} recordings)" if comparison.truths else read)
    return [f"elongation compared with {'; '.join(parts)}"] if parts else []


def _by_channel(comparisons: Sequence[Comparison]) -> Section:
    alone = len(comparisons) == 1
    horizons = list(HORIZONS) if alone else ["open_loop"]
    head = ["1 tick", "10 min", "alone"] if alone else [one.name for one in comparisons]
    title = "channels, rms in K or um" + ("" if alone else ", by the model alone")
    rows = [
        [name, *(number(one.by_channel[name][key], 3) for one in comparisons for key in horizons)]
        for name in comparisons[0].by_channel
    ]
    return Section(title, (), [["channel", *head], *rows])


def _held_out(comparison: Comparison) -> Error:
    return comparison.held_out["open_loop"] if comparison.held_out else Error(float("nan"), float("nan"))


def as_json(comparison: Comparison) -> dict[str, object]:
    """One model's errors for programs."""
    by_channel = comparison.by_channel.items()
    return {
        "name": comparison.name,
        "recordings": recordings_json(comparison.uses),
        **by_horizon(comparison.whole),
        "held_out": vars(_held_out(comparison)) if comparison.held_out else None,
        "by_channel": {name: {KEYS[key]: error for key, error in errors.items()} for name, errors in by_channel},
        "by_phase": {phase: by_horizon(errors) for phase, errors in comparison.by_phase.items()},
        "by_speed_m_min": {f"{speed:g}": by_horizon(errors) for speed, errors in comparison.by_speed.items()},
        "noise_floor": vars(comparison.floor),
        "reference": {"truth": comparison.truths, "readings": comparison.recordings - comparison.truths},
        "warnings": list(comparison.warnings),
    }
