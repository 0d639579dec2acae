"""A review as a page: rig and recordings, errors, each recording with its channels, the model, what was not used."""

from collections.abc import Callable, Iterator, Sequence
from datetime import datetime

import numpy as np

from ballscrew.page.curves import pictures, residual_map
from ballscrew.page.equations import equations
from ballscrew.page.section import Block, Grid, Points, Section, Words, of_report
from ballscrew.report.review_report import error_sections, explained, skipped, told, warm
from ballscrew.report.sections import number
from ballscrew.report.use_report import left_out
from ballscrew.reviewing import Reviewed
from ballscrew.terminal import Rows, duration
from estimator.accuracy.doubts import doubts
from estimator.accuracy.review import Review
from estimator.faults.fault import MAY_DRIFT
from estimator.faults.sentences import sentences
from estimator.inputs.phase import phases
from estimator.rig import Rig

FEW = 2  # recordings that have a table of errors each, and what is said of them there


def title(found: Reviewed) -> str:
    """What the page is about."""
    names = [review.recording.name for review in found.reviews]
    return f"Thermal elongation: {names[0]}" + (f" and {len(names) - 1} more" if len(names) > 1 else "")


def sections(
    found: Reviewed, rig: Rig, drift: Sequence[Section] = (), each: Callable[[int, str], None] = lambda *_: None
) -> list[Section]:
    """All of it, in order; `drift`: what stands between recordings and model. `each` hears how many recordings are
    drawn, and which is next."""
    return [
        rig_and_recordings(found, rig),
        errors(found, rig),
        *_recordings(found, rig, each),
        *drift,
        equations(found.verdict.model),
        not_used(found, rig),
    ]


def errors(found: Reviewed, rig: Rig) -> Section:
    """The figures that `ballscrew review` prints."""
    tables = [of_report(one) for one in error_sections(found.reviews, found.fitted)]
    said = [*explained(found.reviews), *doubts(found.reviews, rig), *warm(found.reviews)]
    return Section("How far the estimates are off", [*tables, Points(said)])


def _recordings(found: Reviewed, rig: Rig, each: Callable[[int, str], None]) -> Iterator[Section]:
    """Of each recording, with what is said of it where the errors stand in one table."""
    for i, review in enumerate(found.reviews):
        each(i, review.recording.name)
        yield recording(review, rig, told(review) if len(found.reviews) > FEW else ())


def recording(review: Review, rig: Rig, said: Sequence[str]) -> Section:
    """Pictures and channels of one recording, after what is said of it."""
    shown = residual_map(review, rig)
    blocks: list[Block] = [Words(said), *pictures(review), *([shown] if shown else [])]
    return Section(review.recording.name, [*blocks, Grid(channels(review, rig), prose=(5, 6))], new_page=True)


def not_used(found: Reviewed, rig: Rig) -> Section:
    """Sensors that failed, what was skipped by reason, and every note."""
    dropped = [[reason, str(count)] for reason, count in skipped(found.reviews)]
    notes = [f"{r.recording.name}: {note}" for r in found.reviews for note in r.recording.notes]
    said = [*found.failed, *sentences([r.use for r in found.reviews], rig)]
    failed = left_out([r.use for r in found.reviews], rig)
    blocks: list[Block] = [Points(said), *([Grid(failed, prose=(1, 2))] if failed else [])]
    blocks += [Grid([["skipped, by reason", "count"], *dropped])] if dropped else []
    blocks += [Section("Notes", [Points(notes)], level=3)] if notes else []
    return Section("What was not used", blocks if said or dropped or notes else [Words(["All was used."])])


def rig_and_recordings(found: Reviewed, rig: Rig) -> Section:
    """What was measured, where and when."""
    head = ["recording", "began", "length", "drives", "driven", "ticks", "frames", "reference", "in the model's fit"]
    fitted = zip(found.reviews, found.fitted, strict=True)
    rows = [head, *(_recording(review, used) for review, used in fitted)]
    without = [["left out as asked", ", ".join(found.without)]] if found.without else []
    blocks = [Grid([*_rig(rig, found.verdict.model.name), *without], prose=(1,)), Grid(rows)]
    return Section("Rig and recordings", blocks)


def _rig(rig: Rig, model: str) -> Rows:
    at = [c.at_mm for c in rig.channels.values() if c.at_mm is not None]
    places = f", {min(at):g} to {max(at):g} mm along it" if at else ""
    lengths = [name for name, channel in rig.channels.items() if not channel.is_thermometer]
    rows = [["rig", rig.name], ["model", model]]
    if (screw := rig.screw) is not None:
        span = "{:g} to {:g} mm".format(*screw.span_mm)
        lead = f"phi {screw.outer_mm:g} / {screw.bore_mm:g} mm, lead {screw.lead_mm:g} mm"
        rows.append(["screw", f"{lead}; elongation is that of {span}"])
    for name, support in rig.supports.items():
        rows.append([f"{name} bearing", f"at {support.at_mm:g} mm"])
    rows.append(["thermometers", f"{len(rig.thermometers)}{places}: {', '.join(rig.thermometers)}"])
    rows.append(["lengths", ", ".join(lengths) or "none"])
    return [*rows, ["inputs", ", ".join(rig.inputs)]]


def _recording(review: Review, fitted: bool) -> list[str]:
    r = review.recording
    began = "" if r.began_s is None else datetime.fromtimestamp(r.began_s).isoformat(" ", "minutes")
    tick_s = float(np.median(np.diff(r.time_s))) if len(r) > 1 else 0.0
    drives = [len(ticks) for driving, ticks in phases(r) if driving]
    told = [str(len(drives)), duration(sum(drives) * tick_s), str(len(r)), str(r.frames or "")]
    return [r.name, began, duration(r.time_s[-1]), *told, review.reference_name, "yes" if fitted else "no"]


def channels(review: Review, rig: Rig) -> Rows:
    """What was used of each channel, and how far it is from what was expected of it."""
    rows = [["channel", "at, mm", "used", "refused", "NIS", "suspect", "why not used"]]
    for one in review.use.channels:
        at = rig.channels[one.channel].at_mm
        share = f"{one.share:.1%}" if np.isfinite(one.share) else "never read"
        suspect = one.suspect.word or (MAY_DRIFT if one.suspicions else "")
        why = ", ".join(f"{count} x {reason}" for reason, count in one.why.items())
        place = "" if at is None else f"{at:g}"
        rows.append([one.channel, place, share, str(one.refused), number(review.nis_of[one.channel]), suspect, why])
    return rows
