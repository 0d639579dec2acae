"""Make the pictures of the live views: FS-20, as somebody sees them who looks on after the second stop.

Views know nothing of logs and filters, so this script brings them together. `make pictures` runs it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from drivers.recordings import read_recording
from estimator.alarms.alarms import Alarms
from estimator.alarms.trust import Watch
from estimator.filter import Filter
from estimator.inputs.phase import turns
from estimator.record import Sample
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.step import Step
from viz.live.live import LiveViews
from viz.viewer.pictures import render_stream

PICTURES = Path(__file__).parent / "pictures" / "live"
RECORDINGS = Path(__file__).parents[1] / "recordings"
RUN, UNTIL_S = "FS-20", 4280.0
BATCH = 60  # ticks
WINDOW = "1440x1000"


def ticks(rig_folder: Path, name: str) -> Iterator[tuple[Sample, Step]]:
    """Samples of a recording and what the filter says of each."""
    rig = load_rig(rig_folder)
    estimate = Filter(load_model(rig_folder / "model.toml"), rig)
    for sample in read_recording(rig_folder / f"{name}.blf", rig):
        yield sample, estimate.step(sample)


def feed(views: LiveViews) -> None:
    """Show the run up to the moment of the pictures, with words on its drives and on how it stands."""
    driving, rig = False, load_rig(RECORDINGS)
    alarms, watch = Alarms(rig), Watch(rig)
    for k, (sample, step) in enumerate(ticks(RECORDINGS, RUN)):
        if step.time_s > UNTIL_S:
            break
        views.show(sample, step)
        alarms.step(step)
        watch.drive(step.time_s)
        watch.tick(sample, step, alarms.diverged)
        views.judge(step.time_s, watch.trust(step.time_s).why, tuple(alarms.active.values()))
        now = f"{step.elongation_um:.1f} ± {2 * step.sigma_um:.1f} µm (2 sd)"
        if turns(sample.omega) != driving:
            driving = not driving
            views.say(step.time_s, "drive starts" if driving else f"drive stops at {now}")
        if k % BATCH == BATCH - 1:
            rows = {"elongation": now, "mode": step.mode.name.lower(), "channels": f"{step.fused.sum()} fused"}
            views.status("\n".join(["| | |", "|---|---|", *(f"| {name} | {text} |" for name, text in rows.items())]))
            views.flush()
    views.flush()


def main() -> None:
    """Feed, look, write."""
    views = LiveViews(load_rig(RECORDINGS), RUN, port=0)
    try:
        feed(views)
        for path in render_stream(views.url, PICTURES, WINDOW):
            print(path)
    finally:
        views.close()


if __name__ == "__main__":
    main()
