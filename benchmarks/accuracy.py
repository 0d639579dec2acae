"""The twelve experiments of the virtual rig: how far each estimate is from the truth, with all channels and fewer."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from ballscrew.muting import muted
from drivers.logs.truth import read_truth
from drivers.recordings import find_recordings, read_recording
from estimator.accuracy.review import Review, overall, review
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig

FOLDER = Path(__file__).parent.parent / "recordings"
COOLDOWN = "telemeter silent for 60 min from the first stop"
SITUATIONS = {
    "15 channels, readings while driving": (None, False, ()),
    "7 channels, readings while driving": (7, False, ()),
    "15 channels, no displacement": (None, True, ()),
    "7 channels, no displacement": (7, True, ()),
    COOLDOWN: (None, False, ("telemeter:stop1",)),
}


def one(path: Path, situation: str) -> Review:
    """Review one recording in one situation."""
    rig = load_rig(FOLDER)
    model = load_model(FOLDER / "model.toml")
    recording = read_recording(path, rig)
    truth = read_truth(path)
    assert truth is not None
    channels, no_displacement, spans = SITUATIONS[situation]
    chosen = rig.subset_7 if channels == 7 else None
    mute = muted(recording, rig, chosen, no_displacement, [f"{s}-{_end(recording)}" for s in spans])
    return review(recording, rig, model, truth.at(recording.time_s), mute, chosen)


def _end(recording) -> float:  # type: ignore[no-untyped-def]
    """60 min after the first stop, s from the first sample."""
    from estimator.inputs.phase import COOLDOWN_S, stops

    return stops(recording)[0] + COOLDOWN_S - float(recording.time_s[0])


def markdown() -> str:
    """The table over all twelve, and over the eight that the model was not fitted to."""
    paths = find_recordings([FOLDER])
    fitted = set(load_model(FOLDER / "model.toml").about["fitted_on"].values())
    rows = []
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for situation in SITUATIONS:
            reviews = list(pool.map(one, paths, [situation] * len(paths)))
            held_out = [r for r in reviews if r.recording.fingerprint not in fitted]
            rows.append(_row(f"**filter**, {situation}", "filter", reviews, held_out))
            if situation == next(iter(SITUATIONS)):
                rows += [_row(name, name, reviews, held_out) for name in reviews[0].errors if name != "filter"]
    head = (
        "| reference - estimate, um | "
        + " | ".join(f"{c} | band | 60 min after stops | in 2 sd" for c in ("all", "8"))
        + " |"
    )
    title = f"## Accuracy: {len(paths)} experiments of the virtual rig against the truth, all and the 8 not fitted"
    return "\n".join([title, "", head, "|---" * 9 + "|", *rows])


def _row(title: str, name: str, everything: Sequence[Review], held_out: Sequence[Review]) -> str:
    cells = [title]
    for reviews in (everything, held_out):
        a = overall(reviews, name)
        inside = f"{a.coverage_2sigma:.1%}" if np.isfinite(a.coverage_2sigma) else ""
        cells += [
            f"{a.band_um[0]:+.2f} .. {a.band_um[1]:+.2f}",
            f"{a.width_um:.2f}",
            f"{a.cooldown_max_um:.2f}",
            inside,
        ]
    return "| " + " | ".join(cells) + " |"
