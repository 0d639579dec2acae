"""What is measured of a model on recordings: a number for each recording, channel and figure.

channels     nis, whiteness, in_2sd, blind_nis, blind_in_2sd of each channel and of `all`
             (estimator/accuracy/quality.py)
horizons     one_step, ahead, open_loop: rms of `thermometers`, K, and `displacement`, um, of a run that the model was
             not fitted to (estimator/accuracy/horizon.py)
truth        band_um, cooldown_max_um, truth_in_2sd of the filter's `elongation`, where a truth file is
"""

import hashlib
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from drivers.logs.truth import read_truth
from drivers.recordings import find_recordings, read_recording
from estimator.accuracy.accuracy import accuracy
from estimator.accuracy.horizon import errors
from estimator.accuracy.quality import overall, quality
from estimator.batch.replay import Replay
from estimator.batch.trial import Trial
from estimator.batch.trials import Trials
from estimator.inputs.phase import cooling
from estimator.model import Model
from estimator.record import Recording
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.step import Track

Key = tuple[str, str, str]  # recording, channel, figure
Figures = dict[Key, float]

PAPER = Path(__file__).parents[2] / "recordings"
CHANNEL = ("nis", "whiteness", "in_2sd", "blind_nis", "blind_in_2sd")
GROUPS = ("all", "thermometers", "elongation")  # rows that are no channel


class Folder:
    """A rig folder: its rig, its model, and its recordings, each read once."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.rig = load_rig(path)
        self.model = load_model(path / "model.toml")
        self._read: dict[str, Recording] = {}
        self._own: dict[str, Figures] = {}

    def names(self) -> list[str]:
        """All recordings of the folder."""
        return [path.name for path in find_recordings([self.path])]

    def keep(self, name: str, recording: Recording) -> None:
        """Take this for one of the folder's recordings."""
        self._read[name] = recording

    def recording(self, name: str) -> Recording:
        """One recording, named as seen from the folder."""
        if name not in self._read:
            self._read[name] = read_recording(self.path / name, self.rig)
        return self._read[name]

    def figures(self, names: Sequence[str]) -> Figures:
        """Figures of the folder's model on some recordings, each measured once; what is not known is left out."""
        for name in names:
            if name not in self._own:
                self._own[name] = self.figures_of(self.model, name)
        return {key: value for name in names for key, value in self._own[name].items()}

    def figures_of(self, model: Model, name: str) -> Figures:
        """Figures of any model on one recording."""
        return {key: value for key, value in self._figures(name, model) if math.isfinite(value)}

    def _figures(self, name: str, model: Model) -> Iterator[tuple[Key, float]]:
        recording = self.recording(name)
        replayed = Replay(model, self.rig, recording, None, lambda _: None)
        trial = replayed.trial
        assert trial is not None
        for channel, figure, value in _channels(trial, model):
            yield (name, channel, figure), value
        if recording.fingerprint not in model.about.get("fitted_on", {}).values():
            for horizon, error in errors(Trials([trial]), model).items():
                yield (name, "thermometers", f"{horizon}_K"), error.temperature_K
                yield (name, "displacement", f"{horizon}_um"), error.elongation_um
        for figure, value in self._truth(name, replayed.track):
            yield (name, "elongation", figure), value

    def _truth(self, name: str, track: Track) -> Iterator[tuple[str, float]]:
        truth = read_truth(self.path / name)
        if truth is None or self.rig.screw is None:
            return
        recording = self.recording(name)
        found = accuracy(truth.at(recording.time_s) - track.elongation_um, track.sigma_um, cooling(recording))
        yield "band_um", found.width_um
        yield "cooldown_max_um", found.cooldown_max_um
        yield "truth_in_2sd", found.coverage_2sigma


def _channels(trial: Trial, model: Model) -> Iterator[tuple[str, str, float]]:
    found = quality(Trials([trial]), model)
    for each in (overall(found), *found):
        for figure in CHANNEL:
            if (each.channel, figure) != ("all", "whiteness"):  # it would be that of one channel
                yield each.channel, figure, getattr(each, figure)


def fingerprint(model: Model) -> str:
    """Twelve characters that change with every effect and value of a model."""
    values = "".join(f"{path} = {value.value:.6g}\n" for path, value in model.values.items())
    return hashlib.sha256(f"{list(model.effects)}\n{values}".encode()).hexdigest()[:12]
