"""One rig folder looked at: how the filter follows, whether the model holds, what is missing, what drifts."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click
from rich.console import Console

from ballscrew.report import diagnosis_report, review_report, trend_report
from ballscrew.reviewing import Asked
from ballscrew.terminal import Terminal
from ballscrew.workspace import Workspace, open_workspace
from estimator.accuracy.review import Review
from estimator.effects import CATALOGUE
from estimator.errors import BallscrewError
from estimator.missing_effect.suggest import suggest
from estimator.missing_heat.diagnose import diagnose
from estimator.model import Model
from estimator.trend.drift import FEWEST
from estimator.trend.trend import trend
from estimator.work import Runs

EVERYTHING = Asked(join=False, channels=None, no_displacement=False, spans=())


@dataclass(frozen=True)
class InspectedRun:
    """One recording: when it began, s since 1970, None where no clock tells; rms of the filter's error, NaN without a
    reference; NIS; rms by which thermometers are off the model alone."""

    began_s: float | None
    filter_um: float
    nis: float
    alone_K: float

    @classmethod
    def of(cls, review: Review) -> "InspectedRun":
        """What of a review is followed over weeks."""
        known = review.accuracy("filter").rms_um
        return cls(review.recording.began_s, known, review.nis_mean, review.open_loop_K)


@dataclass(frozen=True)
class Inspection:
    """What was found of one rig; only `folder` and `error` of one that could not be used.

    recordings  that were used;   failed: why others were not
    filter      errors of the estimate, as `review --json` has them;   nis: mean of the recordings
    adequate    whether the model is, and `where` it fails: as `diagnose --json` has it
    verdict     of `suggest`, where it was asked
    drifts      as `trend --json` has them; None with too few recordings, or a model that no fit has seen
    said        of the model, and of what drifts, in words
    runs        each recording over time, for views
    """

    folder: str
    recordings: int = 0
    failed: Sequence[str] = ()
    filter: Mapping[str, Any] | None = None
    nis: float = float("nan")
    adequate: bool | None = None
    where: Sequence[Mapping[str, Any]] = ()
    verdict: str | None = None
    drifts: Sequence[Mapping[str, Any]] | None = None
    said: Sequence[str] = field(default_factory=list)
    error: str | None = None
    runs: Sequence[InspectedRun] = ()


def inspected(folder: Path, search: bool = False) -> Inspection:
    """Look at a rig folder with its own model and all its recordings; what cannot be used is told, not raised."""
    terminal = Terminal(quiet=True)
    terminal.err = Console(file=io.StringIO())  # a worker has no screen: what is said of recordings is in `failed`
    work: Workspace | None = None
    try:
        work = open_workspace(terminal, [folder], folder, None)
        return _inspected(work, folder, search)
    except BallscrewError as error:
        return Inspection(str(folder), error=str(error))
    except click.exceptions.Exit:
        failed = work.failed if work else []
        return Inspection(str(folder), failed=failed, error="; ".join(failed) or "no recording could be used")


def _inspected(work: Workspace, folder: Path, search: bool) -> Inspection:
    seen = EVERYTHING.reviewed(work)
    if seen is None:
        return Inspection(str(folder), failed=work.failed, error="; ".join(work.failed))
    work.loaded = list(seen.loaded)
    work.part()
    runs = Runs(work.rig, work.recordings)
    figures = review_report.as_json(seen.reviews, seen.fitted, seen.seconds)
    nis = [review.nis_mean for review in seen.reviews]
    diagnosis = diagnose(work.model, runs)
    followed = trend(work.model, runs) if _can_drift(work.model, runs) else None
    found = suggest(work.model, runs, CATALOGUE.values()) if search else None
    drifting = trend_report.sentences(followed) if followed and followed.told else []
    return Inspection(
        str(folder), len(runs.recordings), list(work.failed), figures["overall"].get("filter"), sum(nis) / len(nis),
        diagnosis.adequate, diagnosis_report.as_json(diagnosis, [])["where"], found.verdict if found else None,
        trend_report.as_json(followed)["drifts"] if followed else None, [*diagnosis.sentences, *drifting],
        runs=[InspectedRun.of(review) for review in seen.reviews],
    )  # fmt: skip


def _can_drift(model: Model, runs: Runs) -> bool:
    """Whether a trend can be asked for."""
    return len(runs.recordings) >= FEWEST and any(model.values[path].sd for path in model.free())
