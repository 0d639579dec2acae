"""What the views of a tuning show: innovations before and after."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ballscrew.workspace import Loaded
from estimator.accuracy.quality import innovations
from estimator.batch.trial import Trial
from estimator.fit.tune import Tuned
from estimator.model import Model
from estimator.rig import Rig
from viz.tuning.tuned import Side, Tuning
from viz.tuning.tuning import Nis, save


def save_views(path: Path, rig: Rig, model: Model, loaded: Sequence[Loaded], found: Tuned, page: str) -> None:
    """Write the views of a tuning of `model` into `path`, with `page` (markdown)."""
    runs = [_tuning(one, Trial(model, rig, one.recording), model, found.model) for one in loaded]
    bars = (
        _nis("NIS a tick ahead [1]", found, "nis"),
        _nis("NIS after ten minutes without readings [1]", found, "blind_nis"),
    )
    save(path, rig.names, runs, bars, page)


def _tuning(one: Loaded, trial: Trial, *models: Model) -> Tuning:
    known = [innovations(trial, model) for model in models]
    before, after = (Side(each.scaled, each.autocorrelation) for each in known)
    return Tuning(one.path.stem, known[0].time_s, known[0].lags_s, before, after)


def _nis(title: str, found: Tuned, figure: str) -> Nis:
    before, after = (np.array([getattr(each, figure) for each in some]) for some in (found.before, found.after))
    return Nis(title, before, after)
