"""A diagnosis: tables and JSON."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ballscrew.began import events_json, events_section
from ballscrew.report.sections import HORIZONS, Section, by_horizon, cells, number, print_sections
from ballscrew.report.use_report import recordings_json
from ballscrew.terminal import Terminal
from estimator.accuracy.quality import overall
from estimator.events.event import Event
from estimator.inputs.phase import PHASES
from estimator.missing_heat.diagnose import Diagnosis
from estimator.missing_heat.follows import Follows
from estimator.missing_heat.missing_heat import MissingHeat
from estimator.missing_heat.where import Deficit
from estimator.missing_heat.wrong_reading import Wrong


def print_diagnosis(terminal: Terminal, diagnosis: Diagnosis, events: Sequence[Event]) -> None:
    """Tables, how the filter does, and the diagnosis in words."""
    print_sections(terminal, sections(diagnosis, events))
    white = overall(diagnosis.quality)
    worst = max(diagnosis.quality, key=lambda one: np.nan_to_num(one.whiteness))
    told = f"; largest autocorrelation of what it did not expect {white.whiteness:.2f} ({worst.channel})"
    terminal.say(
        f"\nfilter: NIS {white.nis:.2f} per channel, {100 * white.in_2sd:.0f} % in 2 sd"
        + (told if np.isfinite(white.whiteness) else "")
    )
    for sentence in diagnosis.sentences:
        terminal.say(sentence)


def sections(diagnosis: Diagnosis, events: Sequence[Event]) -> list[Section]:
    """The tables: errors, missing heat, wrong readings, what began within a run."""
    errors = {title: diagnosis.errors[key] for key, title in HORIZONS.items()}
    errors |= {"sensors alone": diagnosis.floor, "good enough alone": diagnosis.limits}
    rows = [[title, *cells([error])] for title, error in errors.items()]
    tables = [Section("how far ahead", (), [["error, rms", "K", "um"], *rows])]
    if diagnosis.where:
        head = ["place", "when", "W", "sd", "follows", "p"]
        said = ["what it would take to repair the run, mean over all recordings"]
        tables.append(Section("missing heat", said, [head, *map(_heat_row, diagnosis.where)]))
    if diagnosis.readings:
        head = ["channel", "offset", "sd", "rms", "unit", "follows", "p"]
        rows = [head, *map(_reading_row, diagnosis.readings)]
        tables.append(Section("wrong readings", ["what no heat explains"], rows))
    if events:
        tables.append(events_section(events))
    return tables


def _heat_row(heat: Deficit) -> list[str]:
    place = heat.node if heat.node is not None else f"{heat.from_mm:.0f} - {heat.to_mm:.0f} mm"
    return [place, PHASES[heat.phase], f"{heat.heat_W:+.2f}", number(heat.sd_W), *_followed(heat.follows)]


def _reading_row(wrong: Wrong) -> list[str]:
    sizes = [f"{wrong.offset:+.3f}", number(wrong.sd, 3), number(wrong.rms, 3)]
    return [wrong.channel, *sizes, wrong.unit, *_followed(wrong.follows)]


def _followed(follows: Follows) -> list[str]:
    return [follows.name or "", f"{follows.p:.3f}"]


def as_json(diagnosis: Diagnosis, events: Sequence[Event]) -> dict[str, Any]:
    """The diagnosis for programs."""
    return {
        "adequate": diagnosis.adequate,
        "recordings": recordings_json(diagnosis.uses),
        "where": [_told(heat, "from_mm", "to_mm", "node", "phase", "heat_W", "sd_W") for heat in diagnosis.where],
        "readings": [_told(wrong, "channel", "offset", "sd", "unit", "rms") for wrong in diagnosis.readings],
        "events": events_json(events),
        "sentences": list(diagnosis.sentences),
        "errors": by_horizon(diagnosis.errors),
        "noise_floor": vars(diagnosis.floor),
        "good_enough": vars(diagnosis.limits),
        "whiteness": [vars(one) for one in diagnosis.quality],
        "missing_heat": {one.misfit.trial.recording.name: _map(one) for one in diagnosis.maps},
    }


def _told(one: Deficit | Wrong, *keys: str) -> dict[str, object]:
    """Fields of a finding, how much it matters, and what it follows."""
    follows = one.follows
    told = {key: getattr(one, key) for key in (*keys, "effect")}
    rivals = [rival.name for rival in follows.rivals]
    return {**told, "follows": follows.name, "p": follows.p, "explains": follows.explains, "rivals": rivals}


def _map(heat: MissingHeat) -> dict[str, object]:
    blocks = zip(heat.blocks.phase, heat.blocks.at_s, heat.blocks.seconds, strict=True)
    return {
        "zones": [{"from_mm": zone.from_mm, "to_mm": zone.to_mm, "node": zone.node} for zone in heat.zones],
        "blocks": [{"phase": phase, "at_s": at, "seconds": seconds} for phase, at, seconds in blocks],
        "heat_W_m": heat.mean,
        "sd_W_m": heat.sd,
    }
