"""A run that live views were shown tick by tick, and the same saved afterwards."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from estimator.filter import Filter
from estimator.record import Sample
from estimator.step import Step, TableErrors, Track
from tests.conftest import at_defaults
from tests.viz_fake import JUDGED, fake_run
from viz.lanes.standing import Glance, Standing
from viz.live.live import LiveViews
from viz.recorded.recorded import save
from viz.recorded.run import ReviewedRun

SECONDS, WAITING, BATCH = 400, 5, 50
Ticks = list[tuple[Sample, Step]]


class Fed(NamedTuple):
    """A run whose first ticks have no thermometer, its ticks one by one, the file that live views made of them, and the
    error over the stroke at last."""

    run: ReviewedRun
    ticks: Ticks
    file: Path
    stroke: TableErrors


def show(views: LiveViews, ticks: Ticks, batch: int = BATCH) -> None:
    """Show ticks, sent in batches."""
    for k, (sample, step) in enumerate(ticks):
        views.show(sample, step)
        if k % batch == batch - 1:
            views.flush()


@pytest.fixture(scope="package")
def fed(tmp_path_factory: pytest.TempPathFactory) -> Fed:
    run = fake_run("FS-20", SECONDS)
    channels = run.recording.channels.copy()
    channels[:WAITING] = np.nan
    recording = replace(run.recording, channels=channels)
    estimate = Filter(at_defaults(), run.rig)
    ticks = [(sample, estimate.step(sample)) for sample in recording]
    track = Track.of([step for _, step in ticks], run.track.x_mm, ())
    file = tmp_path_factory.mktemp("live") / "live.rrd"
    views = LiveViews(run.rig, "FS-20", port=None, save=file)
    views.say(21.0, "drive starts")
    for judged in JUDGED:
        views.judge(judged.time_s, judged.why, judged.alarms, "" if judged.why else "sent")
    show(views, ticks)
    stroke = estimate.table_errors(np.linspace(*run.rig.stroke_mm, 41))
    views.stand(Standing(float(SECONDS), (Glance("elongation", "+1.00 µm", "", "value"),), "**at rest**", stroke))
    views.close()
    assert views.trouble == ""
    return Fed(replace(run, recording=recording, track=track), ticks, file, stroke)


@pytest.fixture(scope="package")
def saved(fed: Fed, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same run saved afterwards."""
    path = tmp_path_factory.mktemp("saved") / "saved.rrd"
    save(path, [fed.run], "")
    return path
