"""What one or two models say of recordings, before and after a change, beside each other: one .rrd file.

Curves are means of ten seconds: a model alone is smooth, and two models on hours of ticks would be a heavy file.
"""

from __future__ import annotations

import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import rerun as rr

from estimator.errors import InputError
from viz.comparison import bars, curves, maps
from viz.comparison.bars import Bars
from viz.comparison.compared import Compared
from viz.comparison.layout import blueprint
from viz.drawing import moment, paths
from viz.drawing.paths import distinct


def save(
    path: Path, runs: Sequence[Compared], models: Sequence[str], figures: Mapping[str, Sequence[Bars]], summary: str
) -> None:  # fmt: skip
    """Write all runs into `path` (.rrd) with `summary` (markdown); models by name.

    figures  of all runs, by the name of their tab; those of the first stand beside the summary
    """
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}")
    runs = distinct(runs)
    scales = maps.scales_of(runs)
    layout = blueprint(runs, models, figures)
    rec = rr.RecordingStream(paths.APPLICATION, recording_id=uuid.uuid4())
    rec.set_log_time_enabled(False)
    rec.save(path, default_blueprint=layout)
    rec.send_blueprint(layout, make_active=True, make_default=True)
    rec.send_recording_name(f"{' and '.join(models)}: {', '.join(run.name for run in runs)}")
    rec.log(paths.SUMMARY, rr.TextDocument(summary, media_type=rr.MediaType.MARKDOWN), static=True)
    moment.send(rec, float(np.floor(max(run.time_s[-1] for run in runs))))
    for tab, some in figures.items():
        for i, each in enumerate(some):
            bars.send(rec, bars.at(tab, i), each)
    for run in runs:
        curves.send(rec, run)
        maps.send(rec, run, scales)
    rec.disconnect()
