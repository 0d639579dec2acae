"""Reviews as a person and as a program read them: tables, sentences and JSON with the same figures."""

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ballscrew.report.sections import Section, number
from ballscrew.report.use_report import as_json as as_json_of_use, print_use
from ballscrew.terminal import Rows, Terminal, duration
from estimator.accuracy.accuracy import Accuracy
from estimator.accuracy.doubts import doubts
from estimator.accuracy.machine import LIMIT_SD
from estimator.accuracy.review import Review, overall
from estimator.rig import Rig

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
NEXT_TICKS = 10.0  # between the end of a part and the begin of the next: a logger changes files
COLUMNS = ("reference - estimate, um", "lowest", "highest", "band", "rms", "cooldown", "in 2 sd")


def print_reviews(
    terminal: Terminal, reviews: Sequence[Review], fitted: Sequence[bool], rig: Rig, said: str = ""
) -> None:
    """A table for each of a few recordings, or a line for each of many; then all together, and those not fitted.

    said  of the model, after what is said of readings
    """
    for section in error_sections(reviews, fitted):
        if section.title:
            terminal.say(f"\n{section.title}")
        if section.rows:
            terminal.table(section.rows)
        for sentence in section.said:
            terminal.say(sentence)
    if terms := explained(reviews):
        terminal.say("\n" + "\n".join(terms))
    print_use(terminal, [review.use for review in reviews], rig)
    said_of_all = (*doubts(reviews, rig), *filter(None, [said]), *parts(reviews, rig), *warm(reviews), *unused(reviews))
    for sentence in said_of_all:
        terminal.say(sentence)


def error_sections(reviews: Sequence[Review], fitted: Sequence[bool]) -> list[Section]:
    """Tables of the errors."""
    judged = any(map(_judged, reviews))
    if judged and len(reviews) > 2:
        found = [Section("", (), [["band, um", *SHORT, "in 2 sd", "NIS"], *map(_line, reviews)])]
    else:
        found = [Section(_head(r), told(r), error_rows([r]) if _judged(r) else ()) for r in reviews]
    if judged and len(reviews) > 1:
        found.append(Section("all recordings together", (), error_rows(reviews)))
    rest = [r for r, was_fitted in zip(reviews, fitted, strict=True) if not was_fitted]
    if judged and rest and len(rest) < len(reviews):
        found.append(Section(f"the {len(rest)} that the model was not fitted to", (), error_rows(rest)))
    return found


def explained(reviews: Sequence[Review]) -> list[str]:
    """What the columns mean, and how well readings know what they are taken as a reference for."""
    if not any(map(_judged, reviews)):
        return []
    known = [r.readings.sd[r.cooling & np.isfinite(r.reference)] for r in reviews if r.reference_name == "readings"]
    sd = np.concatenate([np.empty(0), *known])
    readings = [
        "readings: at rest the direct reading, joined to the drives around it; after a stop known to "
        f"+-{sd.min():.1f} .. {sd.max():.1f} um (1 sd): errors of that size may be its own"
    ] if len(sd) else []  # fmt: skip
    return [
        "band: highest minus lowest; cooldown: largest error in the 60 min after a stop",
        "in 2 sd: share of errors inside two standard deviations of the estimate (and of the readings, where they "
        "are the reference), 95 % when these are honest",
        *readings,
    ]


def warm(reviews: Sequence[Review]) -> list[str]:
    """Which recordings do not begin with a cold screw."""
    return [f"{r.recording.name} {r.start.sentence}" for r in reviews if r.start is not None and r.start.warm]


def _head(review: Review) -> str:
    r = review.recording
    frames = f", {r.frames} frames" if r.frames else ""
    return f"{r.name}: {duration(r.time_s[-1])}, {len(r)} ticks{frames}; reference: {review.reference_name}"


def told(review: Review) -> list[str]:
    """How far thermometers are from what was expected, and the model alone from what it says."""
    said = [] if _judged(review) else ["elongation not judged: neither a displacement channel nor a truth file"]
    if not np.isfinite(review.one_step_K):
        return [*said, "nothing was read after the first thermometer reading: nothing to compare a prediction with"]
    heat = f"{review.one_step_K:.3f} K one tick ahead, {review.open_loop_K:.3f} K by the model alone"
    said.append(f"thermometers minus prediction, rms: {heat}")
    said.append(f"NIS {review.nis_mean:.2f} per channel, 1 when the filter's noise is right")
    if np.isfinite(review.off_sd):
        limit = f"on the machine it was fitted to up to {LIMIT_SD:.1f}"
        said.append(f"the model alone is {review.off_sd:.1f} times as far off as it says, {limit}")
    return said


def _judged(review: Review) -> bool:
    return bool(np.isfinite(review.reference).any())


def skipped(reviews: Sequence[Review]) -> list[tuple[str, int]]:
    """What was dropped, by reason over all recordings; what another state says is no fault and comes last."""
    counts: Counter[str] = Counter()
    for review in reviews:
        counts.update(review.recording.skipped)
    return sorted(counts.most_common(), key=lambda one: one[0].startswith("other state"))


def parts(reviews: Sequence[Review], rig: Rig) -> list[str]:
    """Recordings that go on where another ends, by their dates: that they are parts of one."""
    dated = [(r.recording.began_s, r.recording) for r in reviews if r.recording.began_s is not None]
    ordered = sorted(dated, key=lambda one: one[0])
    pairs = [
        (before.name, after.name)
        for (begin_s, before), (then_s, after) in pairwise(ordered)
        if 0.0 <= then_s + after.time_s[0] - begin_s - before.time_s[-1] <= NEXT_TICKS * rig.tick_s
    ]
    if not pairs:
        return []
    (ended, next_one), more = pairs[0], f", and {len(pairs) - 1} more so" if len(pairs) > 1 else ""
    return [
        f"{next_one} goes on where {ended} ends{more}: with --join they are one recording, which does not begin anew"
    ]


def unused(reviews: Sequence[Review]) -> list[str]:
    """What was dropped, and every note with its place; a reading of before the log is none of it."""
    counts = [one for one in skipped(reviews) if not one[0].startswith("held since before the log")]
    dropped = ", ".join(f"{count} x {reason}" for reason, count in counts)
    notes = [f"{review.recording.name}: {note}" for review in reviews for note in review.recording.notes]
    return [*([f"not used: {dropped}"] if dropped else []), *notes]


def _line(review: Review) -> list[str]:
    widths = [number(review.accuracy(name).width_um) if name in review.errors else "" for name in TITLES]
    return [review.recording.name, *widths, _percent(review.accuracy("filter")), number(review.nis_mean)]


def error_rows(reviews: Sequence[Review]) -> Rows:
    """A row for each estimate, over all recordings together."""
    known = [name for name in TITLES if any(name in r.errors for r in reviews)]
    return [COLUMNS, *(_row(TITLES[name], overall(reviews, name)) for name in known)]


def _row(title: str, a: Accuracy) -> list[str]:
    ends = [f"{end:+.2f}" if np.isfinite(end) else "" for end in a.band_um]
    return [title, *ends, number(a.width_um), number(a.rms_um), number(a.cooldown_max_um), _percent(a)]


def _percent(a: Accuracy) -> str:
    return f"{a.coverage_2sigma:.1%}" if np.isfinite(a.coverage_2sigma) else ""


def as_json(reviews: Sequence[Review], fitted: Sequence[bool], seconds: Sequence[float]) -> dict[str, Any]:
    """The figures for programs."""
    recordings = []
    for r, took in zip(reviews, seconds, strict=True):
        recording, start = r.recording, r.start
        recordings.append({
            "name": recording.name, "reference": r.reference_name, **_errors([r]), "nis_mean": r.nis_mean,
            **_use(r), "temperature_K": {"one_step": r.one_step_K, "open_loop": r.open_loop_K},
            "off_sd": r.off_sd,
            "ticks": len(recording), "frames": recording.frames, "skipped": dict(recording.skipped),
            "notes": list(recording.notes),
            "start": start and {"warm": start.warm, "grown_um": start.grown_um, "sd_um": start.sd_um},
            "seconds": took,
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
