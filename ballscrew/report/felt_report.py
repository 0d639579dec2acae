"""What models leave at the table while the rig cools, as a table, a sentence and JSON."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ballscrew.report.sections import Section, number
from estimator.accuracy.accuracy import Accuracy
from estimator.missing_effect.felt import Felt, felt
from estimator.missing_effect.improve import WORSE
from estimator.model import Model
from estimator.sensitivity.objective import GOOD_UM
from estimator.work import Runs

WAYS = {"seen": "thermometers read", "silent": "nothing read since the stop"}


@dataclass(frozen=True)
class AtTheTable:
    """What each model leaves on some recordings ("used", "held out"), in the order of the models."""

    recordings: str
    models: Sequence[str]
    felt: Sequence[Felt]


def at_the_table(models: Sequence[Model], runs: Mapping[str, Runs]) -> list[AtTheTable]:
    """What models leave on recordings by what they are called; nothing where no elongation is read at rest."""
    found = {title: [felt(model, some) for model in models] for title, some in runs.items() if some.recordings}
    return [
        AtTheTable(title, [model.name for model in models], [one for one in each if one])
        for title, each in found.items()
        if all(each)
    ]


def felt_section(found: Sequence[AtTheTable]) -> Section:
    """The filter's errors in cooldown, model by model."""
    head = ["filter, 60 min after stops", *(c for name in found[0].models for c in (f"{name}, rms um", "at most um"))]
    rows = [
        [f"{one.recordings}, {words}", *(c for each in one.felt for c in _cells(getattr(each, way)))]
        for one in found
        for way, words in WAYS.items()
    ]
    said = "Elongation by the filter against the direct reading, joined at the stop; the filter does not see it"
    return Section("What the axis feels", [said], [head, *rows])


def felt_sentence(found: Sequence[AtTheTable]) -> str:
    """What an axis that is compensated feels of it, before and after: worse is what a good model would not leave."""
    last = found[-1]
    errors = [[most(getattr(each, way)) for each in last.felt] for way in WAYS]
    worse = any(of[-1] > max(WORSE * of[0], GOOD_UM) for of in errors)
    seen, silent = (" -> ".join(map(number, of)) for of in errors)
    return (
        f"At the table the filter is at most {seen} um off in the 60 min after stops while thermometers read, and"
        f" {silent} um if they fall silent at the stop ({last.recordings})."
        + (" That is worse, whatever the model alone does: do not use it without more runs." if worse else "")
    )


def felt_json(found: Sequence[AtTheTable]) -> list[dict[str, Any]]:
    """For programs: um."""
    return [
        {
            "recordings": one.recordings,
            "model": name,
            **{way: {"rms_um": getattr(each, way).rms_um, "most_um": most(getattr(each, way))} for way in WAYS},
        }
        for one in found
        for name, each in zip(one.models, one.felt, strict=True)
    ]


def _cells(error: Accuracy) -> list[str]:
    return [number(error.rms_um), number(most(error))]


def most(error: Accuracy) -> float:
    """The largest error, um."""
    return float(np.abs(error.band_um).max())
