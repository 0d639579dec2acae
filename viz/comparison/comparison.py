"""What one or two models say of recordings, before and after a change, beside each other: one .rrd file.

Curves are means of ten seconds: a model alone is smooth, and two models on hours of ticks would be a heavy file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from viz.comparison import curves, heat, maps
from viz.comparison.compared import ComparedRun
from viz.comparison.layout import bars_at, blueprint
from viz.drawing import bars, paths
from viz.drawing.bars import Bars
from viz.drawing.file import distinct, saved


def save(
    path: Path, runs: Sequence[ComparedRun], models: Sequence[str], figures: Mapping[str, Sequence[Bars]], summary: str
) -> None:  # fmt: skip
    """Write all runs into `path` (.rrd) with `summary` (markdown); models by name.

    figures  of all runs, by the name of their tab; those of the first stand beside the summary
    """
    runs = distinct(runs)
    scales, last_s = maps.scales_of(runs), float(np.floor(max(run.time_s[-1] for run in runs)))
    name = f"{' and '.join(models)}: {', '.join(run.name for run in runs)}"
    with saved(path, blueprint(runs, models, figures, scales), name, summary, last_s) as file:
        for tab, some in figures.items():
            for i, each in enumerate(some):
                bars.send(file / bars_at(tab, i), each)
        for run in runs:
            curves.send(file, run)
            at = file / paths.compared(paths.root(run.name))
            for what in (maps.HEAT, maps.OPEN_LOOP, maps.INNOVATION):
                maps.send(at, run, what, scales[what])
            maps.send_bodies(at, run)
            heat.send(at, run)
