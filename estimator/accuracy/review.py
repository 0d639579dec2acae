"""One recording, every estimate, and how far each is from the reference."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.accuracy import polyline
from estimator.accuracy.accuracy import Accuracy, accuracy, rms
from estimator.accuracy.machine import off_sd
from estimator.accuracy.reference import Joined, readings
from estimator.batch.replay import Replay
from estimator.errors import InputError
from estimator.faults.fault import Fault
from estimator.faults.use import Told, Use, use_of
from estimator.inputs.phase import cooling
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.state.gate import Mute
from estimator.state.warmth import Warmth, warmth
from estimator.step import Mode, TableErrors, Track
from estimator.work import one_thread

OURS = ("filter", "smoothed", "open_loop")  # what counts from the rig's zero_C; all else from the first sample


@dataclass(frozen=True)
class Review:
    """What the filter and its rivals made of one recording; every series is (K,) um, NaN where there is nothing.

    estimates     elongation by name: filter, smoothed, open_loop, polyline, polyline_7, polyline_joined, last_reading
    errors        reference minus estimate, by the same names
    reference     truth where there is one, else the level of the displacement readings (`reference`); NaN without
                  either. It counts from the first sample, to which a rig with a zero_C adds what the filter found grown
                  by then
    readings      of the displacement, joined, whether they are the reference or not
    sigma         standard deviation of each error by its estimate's own word, of filter and smoothed
    smoothed_sd   (K,) um, of the smoothed estimate itself
    cooling       (K,) bool: within 60 min after a stop
    one_step_K    rms of thermometer minus prediction before its use; open_loop_K: minus what the model alone says;
                  without what was refused
    off_sd        how many times as far off as it says the model alone is (`machine`); NaN where nothing tells
    use           what was used of the recording, channel by channel
    start         how warm the screw was at the start; None where nothing tells
    table         the error at the table, were it where was asked for
    """

    recording: Recording
    track: Track
    estimates: Mapping[str, Array]
    errors: Mapping[str, Array]
    reference: Array
    reference_name: str
    readings: Joined
    sigma: Mapping[str, Array]
    smoothed_sd: Array
    cooling: Array
    polyline_channels: int
    one_step_K: float
    open_loop_K: float
    off_sd: float
    use: Use
    start: Warmth | None
    table: TableErrors

    def __repr__(self) -> str:
        """Its errors, an estimate a line."""
        errors = [f"  {name:17} {self.accuracy(name)}" for name in self.errors]
        return "\n".join([f"{self.recording.name}: {self.reference_name} - estimate", *errors])

    def accuracy(self, name: str) -> Accuracy:
        """Accuracy of one estimate on this recording."""
        return overall([self], name)

    @property
    def nis_mean(self) -> float:
        """Mean NIS per fused channel: 1 for a filter whose noise is right."""
        known = np.isfinite(self.track.nis)
        channels = self.track.nis_channels[known].sum()
        return float(self.track.nis[known].sum() / channels) if channels else float("nan")

    @property
    def nis_of(self) -> Mapping[str, float]:
        """Mean square of each channel's innovations over their sd, of those fused after the start; NaN without any."""
        track = self.track
        fused = track.fused & (np.cumsum(track.begins) == track.begins.sum())[:, None] & ~track.begins[:, None]
        z = np.where(fused, track.innovation / track.innovation_sd, np.nan)
        return {name: rms(z[:, i]) ** 2 for i, name in enumerate(track.names)}


@one_thread
def review(
    recording: Recording,
    rig: Rig,
    model: Model,
    truth_um: Array | None = None,
    mute: Mute | None = None,
    channels: Sequence[str] | None = None,
    each: Callable[[int], None] = lambda _: None,
    table_mm: Sequence[float] = (),
) -> Review:
    """Run everything over one recording; one without a thermometer reading is an InputError.

    truth_um  (K,) true elongation at the ticks, where it is known
    mute      what the filter must not fuse
    channels  thermometers of the polyline; all by default
    table_mm  positions of the table to tell the error at
    """
    replayed = Replay(model, rig, recording, mute, each, table_mm)
    track, smoothed = replayed.track, replayed.smoothed()
    if (track.mode == Mode.INIT).all():
        raise _never_read(recording)
    used = list(channels or rig.thermometers)
    began_um = replayed.run.began_um if replayed.run else 0.0
    line = polyline.elongation(recording, rig, used)
    estimates = {
        "filter": track.elongation_um,
        "smoothed": smoothed.elongation_um,
        "open_loop": track.open_loop_um,
        "polyline": line,
    }
    if rig.subset_7:
        estimates["polyline_7"] = polyline.elongation(recording, rig, rig.subset_7)
    read = readings(recording, rig, model, track)
    if "displacement" in rig.channels:
        estimates["polyline_joined"] = polyline.joined_polyline(recording, rig, model, line)
        estimates["last_reading"] = polyline.last_reading(recording, rig, model, line)
    estimates |= {name: um + began_um for name, um in estimates.items() if name not in OURS}
    reference = read.level if truth_um is None else truth_um + began_um
    errors = {name: reference - series for name, series in estimates.items()}
    sigma = {"filter": track.sigma_um, "smoothed": smoothed.sigma_um}
    if truth_um is None and "displacement" in rig.channels:
        _judge_by_readings(errors, sigma, track, rig, read)
    use = use_of(recording, rig, Told.by(track))
    off = off_sd(model, replayed.trial, use) if replayed.trial else float("nan")
    return Review(
        recording, track, estimates, errors, reference, _reference_name(rig, truth_um), read, sigma,
        smoothed.sigma_um, cooling(recording), len(polyline.along_screw(rig, used)),
        _misfit_K(track, track.predicted, rig), _misfit_K(track, track.open_loop, rig),
        off, use, warmth(replayed.run) if replayed.run else None, replayed.table,
    )  # fmt: skip


def _never_read(recording: Recording) -> InputError:
    """No thermometer was: with what the recording's notes and counts say first."""
    skipped = sorted(recording.skipped.items(), key=lambda one: -one[1])[:2]
    said = "; ".join([*recording.notes[:1], *(f"{count} x {reason}" for reason, count in skipped)])
    what = f"no thermometer was ever read; nothing to estimate from{f' ({said})' if said else ''}"
    return InputError(f"{recording.name}: {what}; `ballscrew check` says more")


def _misfit_K(track: Track, expected: Array, rig: Rig) -> float:
    """rms of what the thermometers read, but where they were refused, minus what was expected, (K, m)."""
    after = slice(int(np.flatnonzero(track.begins)[-1]) + 1, None)
    off = np.where(track.fault == Fault.NONE, track.measured - expected, np.nan)
    return rms(off[after, rig.is_thermometer])


def _reference_name(rig: Rig, truth_um: Array | None) -> str:
    if truth_um is not None:
        return "truth"
    return "readings" if "displacement" in rig.channels else "none"


def _judge_by_readings(errors: dict[str, Array], sigma: dict[str, Array], track: Track, rig: Rig, read: Joined) -> None:
    """Let no estimate be judged by a reading that it is made of. Changes errors and sigma.

    The smoother has no error at a fused reading. All sds are those of estimate and reference together.
    """
    fused = track.fused[:, rig.index("displacement")]
    errors |= {"filter": filter_error(track, rig, read), "smoothed": np.where(fused, np.nan, errors["smoothed"])}
    sigma |= {name: np.hypot(own, read.sd) for name, own in sigma.items()}


def filter_error(track: Track, rig: Rig, read: Joined) -> Array:
    """Reading minus the filter's estimate, (K,) um.

    Where a reading was fused, the filter is compared before it was: its estimate of the tick before, grown by what the
    model grows in the tick. The first reading only tells the unknown zero: it has no error.
    """
    fused = track.fused[:, rig.index("displacement")]
    before = track.open_loop_um + np.append(np.nan, (track.elongation_um - track.open_loop_um)[:-1])
    error = np.where(np.cumsum(fused) > 1, read.level - before, np.nan)
    return np.where(fused, error, read.level - track.elongation_um)


def overall(reviews: Sequence[Review], name: str) -> Accuracy:
    """Accuracy of one estimate over several recordings together."""
    found = [r for r in reviews if name in r.errors]
    if not found:
        return accuracy(np.empty(0))
    error = np.concatenate([r.errors[name] for r in found])
    late = np.concatenate([r.cooling for r in found])
    sigma = np.concatenate([r.sigma[name] for r in found]) if name in found[0].sigma else None
    return accuracy(error, sigma, late)
