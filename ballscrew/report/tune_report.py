"""A tuning: tables, sentences, JSON and views."""

from pathlib import Path
from typing import Any

import numpy as np

from ballscrew.report.sections import Section, markdown
from ballscrew.report.use_report import recordings_json
from ballscrew.terminal import Rows
from ballscrew.workspace import Loaded, Workspace
from estimator.accuracy.quality import ChannelQuality, innovations, overall
from estimator.batch.trial import Trial
from estimator.fit.tune import Tuned

LEGEND = (
    "NIS: 1 when the noise is right; whiteness: largest autocorrelation within a minute, 0 when white",
    "in 2 sd: 95 % when honest; blind: of what is read after ten minutes without readings",
)
FIGURES = ("nis", "whiteness", "in_2sd", "blind_nis", "blind_in_2sd")


def sections(tuned: Tuned) -> list[Section]:
    """The tables: noise levels, and innovations of each channel."""
    return [
        Section("Noise levels", sentences(tuned), _levels(tuned)),
        Section("Innovations, before->after", LEGEND, _channels(tuned)),
    ]


def _levels(tuned: Tuned) -> Rows:
    head = ["noise level", "of", "before", "after", "unit"]
    return [head, *([x.path, x.kind, f"{x.before:.4g}", f"{x.after:.4g}", x.unit] for x in tuned.levels)]


def _channels(tuned: Tuned) -> Rows:
    pairs = zip((*tuned.before, overall(tuned.before)), (*tuned.after, overall(tuned.after)), strict=True)
    head = ["channel", "NIS", "whiteness", "in 2 sd", "blind NIS", "blind 2 sd"]
    return [head, *(_row(before, after) for before, after in pairs if after.readings)]


def _row(before: ChannelQuality, after: ChannelQuality) -> list[str]:
    pairs = [(getattr(before, key), getattr(after, key)) for key in FIGURES]
    return [after.channel, *(f"{a:.2f}->{b:.2f}" if np.isfinite(b) else "" for a, b in pairs)]


def sentences(tuned: Tuned) -> list[str]:
    """What a person should know of the outcome."""
    said = []
    if np.isfinite(tuned.missing):
        off = tuned.errors["open_loop"].temperature_K
        said.append(
            f"noise stands in for missing physics here: the model alone is {off:.2f} K off, {tuned.missing:.1f} times"
            " what its sensors leave; look for the missing effect first"
        )
    loud = [x.path for x in tuned.levels if x.kind == "process" and x.after > 3 * x.before]
    if loud:
        rose = max(tuned.factors.places, tuned.factors.others)
        said.append(f"process noise rose {rose:.1f} times: the model explains less than it claimed")
    stays = ", ".join(x.path for x in tuned.levels if x.kind == "measurement" and x.after == x.before)
    if stays:
        said.append(f"not lowered: {stays}; innovations there are not white, so part of a reading's error lasts")
    return said


def as_json(tuned: Tuned) -> dict[str, object]:
    """The tuning for programs."""
    levels = {x.path: {"of": x.kind, "before": x.before, "after": x.after, "unit": x.unit} for x in tuned.levels}
    channels = {
        b.channel: {key: {"before": getattr(a, key), "after": getattr(b, key)} for key in FIGURES}
        for a, b in zip(tuned.before, tuned.after, strict=True)
    }
    errors = {key: vars(error) for key, error in tuned.errors.items()}
    return {
        "recordings": recordings_json(tuned.uses),
        "levels": levels, "channels": channels, "errors": errors, "noise_floor": vars(tuned.floor),
        "process_factors": vars(tuned.factors), "missing_physics": tuned.missing, "sentences": sentences(tuned),
    }  # fmt: skip


def save_views(path: Path, work: Workspace, tuned: Tuned) -> None:
    """Write the views of a tuning into `path`: innovations before and after."""
    from viz.drawing import paths  # rerun takes half a second to import
    from viz.drawing.bars import BarSeries, NisBars
    from viz.tuning.tuning import save

    titles = {"nis": "NIS a tick ahead [1]", "blind_nis": "NIS after ten minutes without readings [1]"}
    both = dict(zip(paths.SIDES, (tuned.before, tuned.after), strict=True))
    bars = [
        NisBars(title, work.rig.names, [
            BarSeries(side, np.array([getattr(one, figure) for one in some]), paths.COMPARED_AS[side])
            for side, some in both.items()
        ])
        for figure, title in titles.items()
    ]  # fmt: skip
    save(path, work.rig.names, [_tuning(one, work, tuned) for one in work.loaded], bars, markdown(sections(tuned)))
    work.terminal.say_views(path)


def _tuning(one: Loaded, work: Workspace, tuned: Tuned) -> Any:
    from viz.tuning.tuning import ScaledInnovations, Tuning

    trial = Trial(work.model, work.rig, one.recording)
    known = {side: innovations(trial, model) for side, model in (("before", work.model), ("after", tuned.model))}
    time_s, lags_s = known["after"].time_s, known["after"].lags_s
    sides = {side: ScaledInnovations(some.scaled, some.autocorrelation) for side, some in known.items()}
    return Tuning(one.path.stem, time_s, lags_s, sides)
