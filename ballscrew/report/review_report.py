"""Reviews as a person and as a program read them: tables, markdown and JSON with the same figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from ballscrew.report.sections import number, table
from ballscrew.report.use_report import as_json as as_json_of_use
from ballscrew.report.use_report import left_out, print_use
from ballscrew.terminal import Rows, Terminal, duration
from estimator.accuracy.accuracy import Accuracy, least_squares_line
from estimator.accuracy.doubts import doubts
from estimator.accuracy.machine import LIMIT_SD
from estimator.accuracy.review import Review, overall
from estimator.faults.sentences import sentences
from estimator.rig import Rig
from estimator.state.warmth import Warmth

TITLES = {
    "filter": "filter",
    "smoothed": "smoothed, after the fact",
    "open_loop": "model alone (open loop)",
    "polyline": "polyline, all thermometers",
    "polyline_7": "polyline, the rig's seven",
    "polyline_joined": "polyline from the last reading",
    "last_reading": "last reading held",
}
SHORT = ("filter", "smoothed", "model", "polyline", "seven", "joined", "held")
COLUMNS = ("reference - estimate, um", "lowest", "highest", "band", "rms", "cooldown", "in 2 sd")


def print_reviews(
    terminal: Terminal, reviews: Sequence[Review], fitted: Sequence[bool], rig: Rig, said: str = ""
) -> None:
    """A table for each of a few recordings, or a line for each of many; then all together, and those not fitted.

    said  of the model, after what is said of readings
    """
    judged = any(map(_judged, reviews))
    many = judged and len(reviews) > 2
    if many:
        terminal.table([["band, um", *SHORT, "in 2 sd", "NIS"], *map(_line, reviews)])
    else:
        for review in reviews:
            _print_one(terminal, review)
    if judged and len(reviews) > 1:
        terminal.say("\nall recordings together")
        terminal.table(_rows(reviews))
    rest = [r for r, was_fitted in zip(reviews, fitted, strict=True) if not was_fitted]
    if judged and rest and len(rest) < len(reviews):
        terminal.say(f"\nthe {len(rest)} that the model was not fitted to")
        terminal.table(_rows(rest))
    if judged:
        terminal.say("\nband: highest minus lowest; cooldown: largest error in the 60 min after a stop")
        terminal.say(
            "in 2 sd: share of errors inside two standard deviations of the estimate (and of the readings, where they "
            "are the reference), 95 % when these are honest"
        )
        _print_reference(terminal, reviews)
    print_use(terminal, [review.use for review in reviews], rig)
    for sentence in (*doubts(reviews, rig), *filter(None, [said])):
        terminal.say(sentence)
    _print_warm(terminal, reviews)
    _print_unused(terminal, reviews)


def _print_warm(terminal: Terminal, reviews: Sequence[Review]) -> None:
    """Which recordings do not begin with a cold screw."""
    for review in reviews:
        if review.start is not None and review.start.warm:
            terminal.say(f"{review.recording.name} {review.start.sentence}")


def _print_one(terminal: Terminal, review: Review) -> None:
    r = review.recording
    length = f"{duration(r.time_s[-1])}, {len(r)} ticks" + (f", {r.frames} frames" if r.frames else "")
    terminal.say(f"\n{r.name}: {length}; reference: {review.reference_name}")
    if _judged(review):
        terminal.table(_rows([review]))
    else:
        terminal.say("elongation not judged: neither a displacement channel nor a truth file")
    if not np.isfinite(review.one_step_K):
        terminal.say("nothing was read after the first thermometer reading: nothing to compare a prediction with")
        return
    heat = f"{review.one_step_K:.3f} K one tick ahead, {review.open_loop_K:.3f} K by the model alone"
    terminal.say(f"thermometers minus prediction, rms: {heat}")
    terminal.say(f"NIS {review.nis_mean:.2f} per channel, 1 when the filter's noise is right")
    if np.isfinite(review.off_sd):
        limit = f"on the machine it was fitted to up to {LIMIT_SD:.1f}"
        terminal.say(f"the model alone is {review.off_sd:.1f} times as far off as it says, {limit}")


def _print_reference(terminal: Terminal, reviews: Sequence[Review]) -> None:
    """How well the readings know what they are taken as a reference for."""
    known = [r.readings.sd[r.cooling & np.isfinite(r.reference)] for r in reviews if r.reference_name == "readings"]
    sd = np.concatenate([np.empty(0), *known])
    if len(sd):
        terminal.say(
            "readings: at rest the direct reading, joined to the drives around it; after a stop known to "
            f"+-{sd.min():.1f} .. {sd.max():.1f} um (1 sd): errors of that size may be its own"
        )


def _judged(review: Review) -> bool:
    return bool(np.isfinite(review.reference).any())


def _print_unused(terminal: Terminal, reviews: Sequence[Review]) -> None:
    """What was dropped, by reason over all recordings, and every note with its place."""
    counts: Counter[str] = Counter()
    for review in reviews:
        counts.update(review.recording.skipped)
    if counts:
        faults_first = sorted(counts.most_common(), key=lambda one: one[0].startswith("other state"))
        terminal.say("not used: " + ", ".join(f"{count} x {reason}" for reason, count in faults_first))
    for review in reviews:
        for note in review.recording.notes:
            terminal.say(f"{review.recording.name}: {note}")


def _line(review: Review) -> list[str]:
    widths = [number(review.accuracy(name).width_um) if name in review.errors else "" for name in TITLES]
    return [review.recording.name, *widths, _percent(review.accuracy("filter")), number(review.nis_mean)]


def _rows(reviews: Sequence[Review]) -> Rows:
    known = [name for name in TITLES if any(name in r.errors for r in reviews)]
    return [COLUMNS, *(_row(TITLES[name], overall(reviews, name)) for name in known)]


def _row(title: str, a: Accuracy) -> list[str]:
    ends = [f"{end:+.2f}" if np.isfinite(end) else "" for end in a.band_um]
    return [title, *ends, number(a.width_um), number(a.rms_um), number(a.cooldown_max_um), _percent(a)]


def _percent(a: Accuracy) -> str:
    return f"{a.coverage_2sigma:.1%}" if np.isfinite(a.coverage_2sigma) else ""


def markdown(reviews: Sequence[Review], rig: Rig, said: str = "") -> str:
    """The summary page of the views: what is said of the model, the overall table, the least-squares lines, and what
    was not used."""
    lines = ["# Elongation: reference minus estimate", "", *([said, ""] if said else []), *table(_rows(reviews))]
    lines += ["", "The least-squares line Y = aX + b of reference Y against estimate X, and the band around it:", ""]
    for name in ("filter", "polyline"):
        found = [r for r in reviews if name in r.errors]
        reference = np.concatenate([r.reference for r in found])
        estimate = reference - np.concatenate([r.errors[name] for r in found])
        a, b, band = least_squares_line(estimate, reference)
        if np.isfinite(a):
            lines.append(f"- {TITLES[name]}: Y = {a:.4f} X {b:+.2f} um, {band[0]:+.2f} .. {band[1]:+.2f} um")
    if rows := left_out([r.use for r in reviews], rig):
        lines += ["", "Sensors that failed:", "", *table(rows)]
    for r in reviews:
        used = f"{r.recording.frames} frames, reference: {r.reference_name}, NIS {r.nis_mean:.2f}"
        lines += ["", f"**{r.recording.name}**: {duration(r.recording.time_s[-1])}, {used}"]
        lines += [f"- {sentence}" for sentence in (*sentences([r.use], rig), *doubts([r], rig))]
        lines += [f"- not used: {count} x {reason}" for reason, count in r.recording.skipped.items()]
        lines += [f"- {note}" for note in r.recording.notes]
    return "\n".join(lines)


def _start(start: Warmth | None) -> dict[str, Any] | None:
    return start and {"warm": start.warm, "grown_um": start.grown_um, "sd_um": start.sd_um}


def as_json(reviews: Sequence[Review], fitted: Sequence[bool], seconds: Sequence[float]) -> dict[str, Any]:
    """The figures for programs."""
    recordings = []
    for r, took in zip(reviews, seconds, strict=True):
        recording = r.recording
        recordings.append({
            "name": recording.name, "reference": r.reference_name, **_errors([r]), "nis_mean": r.nis_mean,
            **_use(r), "temperature_K": {"one_step": r.one_step_K, "open_loop": r.open_loop_K},
            "off_sd": r.off_sd,
            "ticks": len(recording), "frames": recording.frames, "skipped": dict(recording.skipped),
            "notes": list(recording.notes), "start": _start(r.start), "seconds": took,
        })  # fmt: skip
    rest = [r for r, was_fitted in zip(reviews, fitted, strict=True) if not was_fitted]
    return {"recordings": recordings, "overall": _errors(reviews), "held_out": _errors(rest) if rest else None}


def _use(review: Review) -> dict[str, Any]:
    told = as_json_of_use(review.use)
    channels = {name: {**one, "nis": review.nis_of[name]} for name, one in told["channels"].items()}
    return {**told, "channels": channels}


def _errors(reviews: Sequence[Review]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for name in TITLES:
        if not any(name in r.errors for r in reviews):
            continue
        a = overall(reviews, name)
        result[name] = {"band_um": a.band_um, "rms_um": a.rms_um, "cooldown_max_um": a.cooldown_max_um}
        if name in ("filter", "smoothed"):
            result[name]["coverage_2sigma"] = a.coverage_2sigma
        if name == "polyline":
            result[name]["channels"] = reviews[0].polyline_channels
    return result
