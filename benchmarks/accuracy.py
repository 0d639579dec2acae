"""The twelve experiments of the virtual rig: how far each estimate is from the truth, with all channels and fewer."""

import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from ballscrew.muting import muted
from benchmarks import paper_rig
from benchmarks.measure import section
from drivers.logs.truth import read_truth
from drivers.recordings import find_recordings, read_recording
from drivers.virtual_rig.protocol import EXPERIMENTS
from estimator.accuracy.review import Review, overall, review
from estimator.inputs.phase import COOLDOWN_S, stops
from estimator.record import Recording
from estimator.rig import Rig
from estimator.state.gate import Mute

SITUATIONS = {
    "15 channels, readings while driving": (None, False, ()),
    "7 channels, readings while driving": (7, False, ()),
    "15 channels, no displacement": (None, True, ()),
    "7 channels, no displacement": (7, True, ()),
    "telemeter silent for 60 min from the first stop": (None, False, ("telemeter:stop1",)),
}


def one(path: Path, situation: str) -> Review:
    """Review one recording in one situation."""
    rig = paper_rig.rig()
    recording = read_recording(path, rig)
    truth = read_truth(path)
    assert truth is not None
    mute = mute_in(situation, recording, rig)
    return review(recording, rig, paper_rig.model(), truth.at(recording.time_s), mute, chosen_in(situation, rig))


def chosen_in(situation: str, rig: Rig) -> tuple[str, ...] | None:
    """The thermometers of a situation; None: all."""
    return rig.subset_7 if SITUATIONS[situation][0] == 7 else None


def mute_in(situation: str, recording: Recording, rig: Rig) -> Mute:
    """What the filter must not fuse in a situation."""
    _, no_displacement, spans = SITUATIONS[situation]
    end_s = stops(recording)[0] + COOLDOWN_S - float(recording.time_s[0])  # an hour after the first stop
    texts = [f"{span}-{end_s}" for span in spans]
    return muted(recording, rig, chosen_in(situation, rig), no_displacement, texts)


def markdown() -> str:
    """The table over all twelve, and over the eight that the model was not fitted to."""
    paths = find_recordings([paper_rig.FOLDER])
    if missing := {*EXPERIMENTS} - {path.stem for path in paths}:
        raise SystemExit(f"{paper_rig.FOLDER}: no {', '.join(sorted(missing))}; make recordings")
    fitted = set(paper_rig.model().about["fitted_on"].values())
    rows = []
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for situation in SITUATIONS:
            reviews = list(pool.map(one, paths, [situation] * len(paths)))
            held_out = [r for r in reviews if r.recording.fingerprint not in fitted]
            rows.append(_row(f"**filter**, {situation}", "filter", reviews, held_out))
            if situation == next(iter(SITUATIONS)):
                rows += [_row(name, name, reviews, held_out) for name in reviews[0].errors if name != "filter"]
    head = ["reference - estimate, um"]
    head += [cell for which in ("all", "8") for cell in (which, "band", "60 min after stops", "in 2 sd")]
    title = f"Accuracy: {len(paths)} experiments of the virtual rig against the truth, all and the 8 not fitted"
    return section(title, [head, *rows])


def _row(title: str, name: str, everything: Sequence[Review], held_out: Sequence[Review]) -> list[str]:
    cells = [title]
    for reviews in (everything, held_out):
        a = overall(reviews, name)
        inside = f"{a.coverage_2sigma:.1%}" if np.isfinite(a.coverage_2sigma) else ""
        band = f"{a.band_um[0]:+.2f} .. {a.band_um[1]:+.2f}"
        cells += [band, f"{a.width_um:.2f}", f"{a.cooldown_max_um:.2f}", inside]
    return cells
