"""What a search for a missing effect found: ranking, verdict in words, JSON."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.markup import escape

from ballscrew.began import events_json
from ballscrew.report.search.composed_words import composed_json, own_json, own_words
from ballscrew.report.search.next_run_words import next_run_json
from ballscrew.report.search.verdict import sentence, thermometer_of
from ballscrew.report.sections import Section, cells, with_sd
from ballscrew.report.use_report import recordings_json
from ballscrew.search import Verdict
from ballscrew.terminal import Terminal
from estimator.accuracy.noise_floor import Error
from estimator.events.event import Event
from estimator.hypotheses.candidates import Candidate
from estimator.hypotheses.criterion import behind
from estimator.hypotheses.hypothesis import Hypothesis
from estimator.inputs.follower import Follower
from estimator.missing_effect.suggestion import Suggestion
from estimator.rig import Rig
from estimator.unknown.stand_ins import unknown_of

SHOWN = 6  # effects in the ranking
FEW = 3  # thermometers that are named one by one


def print_verdict(terminal: Terminal, verdict: Verdict, rig: Rig) -> None:
    """The ranking as a table, and the verdict."""
    section = section_of(verdict, rig)
    rows = [[escape(cell) for cell in row] for row in section.rows]  # a name of the rig is no markup
    terminal.table(rows, prose=len(rows[0]) - 1)
    said, note = section.said
    terminal.say(f"({note})\n\n{said}")


def section_of(verdict: Verdict, rig: Rig) -> Section:
    """The verdict, what errors were taken on, and the ranking of hypotheses."""
    head = ["open loop, rms", "K", "um", *(["held out, K", "um"] if verdict.held_out else []), "fitted", "value"]
    rows = [_row(rig, *one) for one in ranked(verdict)] + _stand_ins(verdict, rig)
    once = "one recording: none left out" if verdict.suggestion.one_recording else "each recording left out once"
    once = f"without {verdict.suggestion.apart}, {once}" if verdict.suggestion.apart else once
    note = f"{once}; {'held out: never looked at; ' if verdict.held_out else ''}best first"
    if heard := verdict.suggestion.believed:
        who = ", ".join(heard) if len(heard) <= FEW else f"{len(heard)} thermometers"
        note += f"; heard all the same: {who}, for a fault does not jump whenever the drive starts or stops"
    return Section(
        "What is missing",
        [sentence(verdict, rig), note],
        [head, *([*row, *[""] * (len(head) - len(row))] for row in rows)],
    )


def ranked(verdict: Verdict) -> list[tuple[str, Hypothesis, Error | None]]:
    """Hypotheses with their title and error held out: the model, fitted again, and the best effects."""
    suggestion = verdict.suggestion
    given = "the model, give or take its sd" if suggestion.as_given.ground.learned else "the model as given"
    again, free = "all parameters fitted again", suggestion.as_given.ground.model.free()
    again += ", fixed ones too" if set(suggestion.again.paths) - set(free) else ""
    listed = [(given, suggestion.as_given), (again, suggestion.again)]
    for h in suggestion.found[:SHOWN]:
        listed.append((f"{h.freed} of another value" if h.freed else f"+ {' + '.join(h.names)}", h))
    held: Sequence[Error | None] = verdict.held_out or [None] * len(listed)
    return [(*one, error) for one, error in zip(listed, held, strict=False)]


def _row(rig: Rig, title: str, h: Hypothesis, held: Error | None) -> list[str]:
    errors = [h.judged.error, *([held] if held is not None else [])]
    values = [own_words(h), f"of {thermometer}" if (thermometer := thermometer_of(h, rig)) else ""]
    by = "all" if h.refit else "it alone" if h.names else ""
    return [title, *cells(errors), by, ", ".join(filter(None, values))]


def _stand_ins(verdict: Verdict, rig: Rig) -> list[list[str]]:
    """Rows of something unknown, of the effect that it is, and of what explains as much."""
    suggestion = verdict.suggestion
    found = suggestion.unexplained
    if found is None or suggestion.others.verdict != "nothing_in_catalogue":
        return []
    blank = ["", ""] if verdict.held_out else []
    fitted = "all" if found.hypothesis.refit else "it alone"
    per = _per(unknown_of(found.candidate, rig).follower)
    value = ", ".join(with_sd(v, f"{key}{per}") for key, v in found.strength().items())
    rows = [[_title(found.candidate, rig), *cells([found.judged.error]), *blank, fitted, value]]
    if suggestion.composed is not None:
        made = suggestion.composed
        rows.append(_row(rig, f"+ {made.effect.name}, composed", made.hypothesis, verdict.composed_held_out))
    for rival in found.rivals[:SHOWN]:
        behind_by = f"{rival.difference_se:.1f} standard errors behind"
        rows.append([_title(rival.candidate, rig), *cells([rival.judged.error]), *blank, "screened", behind_by])
    return rows


def _per(follower: Follower) -> str:
    """By what a strength is divided: the unit of what it follows."""
    if follower.loss:
        return "/K"
    return f"/({follower.unit})" if "/" in follower.unit else f"/{follower.unit}" if follower.unit else ""


def _title(candidate: Candidate, rig: Rig) -> str:
    unknown = unknown_of(candidate, rig)
    return f"{unknown.what}, with {unknown.follower.name}"


def as_json(verdict: Verdict, rig: Rig, file: Path | None = None) -> dict[str, Any]:
    """The verdict for programs; `file`: where a composed effect was written."""
    suggestion, made = verdict.suggestion, verdict.suggestion.composed
    held = list(verdict.held_out)
    held_before = held[made.hypothesis.refit] if made is not None and held else None
    wrong = suggestion.wrong_input
    return {
        "recordings": recordings_json(verdict.uses),
        "verdict": suggestion.verdict,
        "effects": [
            {"channel": thermometer_of(h, rig) or None}
            | _effect(suggestion.without(h), h, suggestion.found[0], held[h.refit : h.refit + 1], held[i : i + 1])
            for i, h in enumerate(suggestion.found, start=2)
        ],
        "tie": list(suggestion.tie),
        "next_run": next_run_json(verdict.next_run),
        "input": None if wrong is None else {
            "run": wrong.run, "signal": wrong.signal, "ratio": wrong.ratio, "shift_K": wrong.shift_K,
            "shift_mm": wrong.shift_mm,
        },
        "where": _unknown(suggestion, rig),
        "composed": composed_json(made, held_before, verdict.composed_held_out, file),
        "events": events_json(suggestion.events), "loosened": suggestion.loosened,
        "pair": list(suggestion.pair), "heard": list(suggestion.believed),
        "sentence": sentence(verdict, rig),
    }  # fmt: skip


def _unknown(suggestion: Suggestion, rig: Rig) -> dict[str, Any] | None:
    if suggestion.unexplained is None or suggestion.others.verdict != "nothing_in_catalogue":
        began = suggestion.events if suggestion.verdict == "nothing_in_catalogue" else ()
        return _since(began[0]) if began else None
    unknown = unknown_of(suggestion.unexplained.candidate, rig)
    others = [(unknown_of(rival.candidate, rig), rival.difference_se) for rival in suggestion.unexplained.rivals]
    at, follower = unknown.at_mm, unknown.follower
    return {
        "from_mm": at - 30.0 if at is not None else None, "to_mm": at + 30.0 if at is not None else None,
        "node": unknown.node, "phase": follower.phase, "follows": follower.name, "what": unknown.place,
        "rivals": [
            {"what": other.place, "follows": other.follower.name, "difference_se": se} for other, se in others
        ],
    }  # fmt: skip


def _since(event: Event) -> dict[str, Any]:
    node = event.name if event.from_mm is None else None
    return {
        "from_mm": event.from_mm, "to_mm": event.to_mm, "node": node, "phase": None, "follows": None,
        "what": event.what, "rivals": [],
    }  # fmt: skip


def _effect(
    before: Hypothesis, h: Hypothesis, best: Hypothesis, held_before: Sequence[Error], held: Sequence[Error]
) -> dict[str, Any]:
    return {
        "name": " + ".join(h.names), "score": before.misfit / h.misfit, "refitted": h.refit,
        "at_bound": bool(h.at_bound()), "difference_se": behind(h.judged, best.judged) if h is not best else 0.0,
        "before": vars(before.judged.error), "after": vars(h.judged.error),
        "held_out_before": vars(held_before[0]) if held_before else None,
        "held_out_after": vars(held[0]) if held else None,
        "parameters": own_json(h),
    }  # fmt: skip
