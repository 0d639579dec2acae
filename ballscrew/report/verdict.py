"""What a search for a missing effect found, in words and as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ballscrew.report.unknown import new_effect_line, where
from estimator.accuracy.floor import Error
from estimator.missing_effect.hypothesis import Hypothesis
from estimator.missing_effect.next_run import NextRun
from estimator.missing_effect.stand_ins import unknown_of
from estimator.missing_effect.suggestion import GOOD, Suggestion
from estimator.rig import Rig

ONE = " By one recording, from which nothing could be left out: make another to be sure."
APART_SD = 3.0  # a run that sets rivals less apart does not tell


@dataclass(frozen=True)
class Finding:
    """A suggestion with what it says of recordings held out, and of a run to make.

    held_out  open-loop error of the model as given, fitted again, then of all `found`; empty without such recordings
    """

    suggestion: Suggestion
    held_out: Sequence[Error]
    next_run: NextRun | None


def sentence(finding: Finding, rig: Rig) -> str:
    """The verdict in words, and how far it can be trusted."""
    return _verdict(finding, rig) + (ONE if finding.suggestion.one_recording else "")


def _verdict(finding: Finding, rig: Rig) -> str:
    found = finding.suggestion
    if found.verdict == "input_error" and found.wrong_input is not None:
        wrong = found.wrong_input
        head, rest = "Nothing is missing but in", ""
        if found.far:
            head, rest = (
                "First of all look at",
                f" Set right it still leaves {wrong.judged.heat_K:.3f} K: more is missing.",
            )
        size = f"{wrong.ratio:.2f} times" if wrong.ratio != 1 else f"{wrong.shift_K:+.1f} K off"
        return f"{head} {wrong.run}, where {wrong.signal} is {size} what it should be: check that run.{rest}"
    if found.verdict == "nothing_in_catalogue" and found.stranger is not None:
        unknown = unknown_of(found.stranger.candidate, rig)
        what = "heat" if unknown.channel is None else "an offset of"
        return (
            f"No effect of the catalogue explains it. Something like {what} {where(unknown)} does, which follows"
            f" {unknown.follower.words}. Begin with: {new_effect_line(unknown)}"
        )
    if found.verdict == "nothing_in_catalogue":
        return (
            f"Something is missing, for the model alone leaves {_left(found)}, but no effect that was tried explains"
            " it, nor does anything at one place that follows one input. ballscrew diagnose says where and when."
        )
    if found.verdict == "nothing_missing":
        return _nothing(found)
    best = found.found[0]
    if found.verdict == "tie":
        return _tie(found, finding.next_run)
    more = f" A second one besides: {_other(found)}." if found.pair else ""
    return f"{_missing(found, best)}: {_gain(found.without(best), best)}.{more}"


def _missing(found: Suggestion, best: Hypothesis) -> str:
    name = best.names[0]
    return (
        f"{name} is there, but not as the model says" if name in found.as_given.model.effects else f"{name} is missing"
    )


def _nothing(found: Suggestion) -> str:
    left = _left(found)
    if found.before.refit and found.as_given.misfit > max(GOOD, 1.2 * found.before.misfit):
        return f"Nothing is missing, but the parameters are off: fit the model again, which leaves {left}."
    return f"Nothing is missing: the model alone leaves {left}, and no effect makes that clearly less."


def _left(found: Suggestion) -> str:
    um = found.before.judged.length_um
    return f"{found.before.judged.heat_K:.3f} K" + (f" and {um:.2f} um" if np.isfinite(um) else "")


def _tie(found: Suggestion, run: NextRun | None) -> str:
    names = " or ".join(found.tie)
    if run is None:
        return f"{names}: these recordings cannot tell."
    if run.separation_sd < APART_SD:
        return f"{names}: these recordings cannot tell, and no run of the patterns and speeds seen would."
    low, high = run.stroke_mm
    return (
        f"{names}: these recordings cannot tell. A run {run.pattern} ({low:.0f} - {high:.0f} mm) at {run.speed_m_min:g}"
        f" m/min, {run.drive_s / 60:.0f} min of drive and {run.stop_s / 60:.0f} min of stop, sets them"
        f" {run.separation_sd:.0f} sd apart."
    )


def _other(found: Suggestion) -> str:
    rest = [name for name in found.pair if name != found.found[0].names[0]]
    return rest[0] if rest else found.pair[-1]


def _gain(before: Hypothesis, after: Hypothesis) -> str:
    a, b = before.judged, after.judged
    where = " on recordings left out" if len(b.runs) > 1 else ""
    length = f", elongation {a.length_um:.2f} -> {b.length_um:.2f} um" if np.isfinite(b.length_um) else ""
    return f"temperatures {a.heat_K:.3f} -> {b.heat_K:.3f} K{length}{where}"


def as_json(finding: Finding, rig: Rig) -> dict[str, Any]:
    """The verdict for programs."""
    found, run = finding.suggestion, finding.next_run
    held = list(finding.held_out)
    wrong = found.wrong_input
    return {
        "verdict": found.verdict,
        "effects": [
            _effect(found.without(h), h, held[h.refit : h.refit + 1], held[i : i + 1])
            for i, h in enumerate(found.found, start=2)
        ],
        "tie": list(found.tie),
        "next_run": None if run is None or found.verdict != "tie" else {
            "pattern": run.pattern, "speed_m_min": run.speed_m_min, "drive_s": run.drive_s, "stop_s": run.stop_s,
            "separation_sd": run.separation_sd, "stroke_mm": run.stroke_mm,
        },
        "input": None if wrong is None or found.verdict != "input_error" else {
            "run": wrong.run, "signal": wrong.signal, "ratio": wrong.ratio, "shift_K": wrong.shift_K,
        },
        "where": _unknown(found, rig),
        "pair": list(found.pair),
        "sentence": sentence(finding, rig),
    }  # fmt: skip


def _unknown(found: Suggestion, rig: Rig) -> dict[str, Any] | None:
    if found.stranger is None or found.verdict != "nothing_in_catalogue":
        return None
    unknown = unknown_of(found.stranger.candidate, rig)
    at, follower = unknown.at_mm, unknown.follower
    return {
        "from_mm": at - 30.0 if at is not None else None, "to_mm": at + 30.0 if at is not None else None,
        "node": unknown.node, "phase": follower.phase, "follows": follower.name, "what": where(unknown),
    }  # fmt: skip


def _effect(before: Hypothesis, h: Hypothesis, held_before: Sequence[Error], held: Sequence[Error]) -> dict[str, Any]:
    own = {path: value for path, value in h.parameters().items() if path.partition(".")[0] in h.names}
    return {
        "name": h.names[0], "score": before.misfit / h.misfit, "refitted": h.refit,
        "before": _error(before), "after": _error(h),
        "held_out_before": vars(held_before[0]) if held_before else None,
        "held_out_after": vars(held[0]) if held else None,
        "parameters": {
            path.partition(".")[2]: {"value": value.value, "sd": value.sd, "unit": h.model.param(path).unit}
            for path, value in own.items()
        },
    }  # fmt: skip


def _error(h: Hypothesis) -> Mapping[str, float]:
    return {"temperature_K": h.judged.heat_K, "elongation_um": h.judged.length_um}
