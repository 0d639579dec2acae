"""A review as a page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from ballscrew.page.curves import pictures, residual_map
from ballscrew.page.equations import equations
from ballscrew.page.recordings import channels, failed, rig_and_recordings
from ballscrew.page.section import Block, Grid, Points, Section, Words, of_report
from ballscrew.report.review_report import error_sections, explained, skipped, told, warm
from ballscrew.reviewing import Reviewed
from estimator.accuracy.doubts import doubts
from estimator.accuracy.review import Review
from estimator.faults.sentences import sentences
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
    blocks: list[Block] = [Points(said), *failed(found, rig)]
    blocks += [Grid([["skipped, by reason", "count"], *dropped])] if dropped else []
    blocks += [Section("Notes", [Points(notes)], level=3)] if notes else []
    return Section("What was not used", blocks if said or dropped or notes else [Words(["All was used."])])
