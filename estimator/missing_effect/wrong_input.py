"""Whether one recording among several has a wrong input: a speed in other units, a label, a shifted thermometer.

Of a run that the others miss (`odd_run`) it is asked: is there a ratio of one of its inputs, or a shift of a
temperature or of the position, with which the model suits this run as well? A wrong speed or position alone would show
without any model: the table would not go as far as the screw turns. What a start has set right is not shifted: that far
from a rig in equilibrium no temperature was.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from estimator.batch.trial import Trial
from estimator.batch.trials import Trials, beside, slow_trial, unjudged
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.moments import moments_of
from estimator.hypotheses.panel import Explanation, Panel
from estimator.hypotheses.slopes import Column
from estimator.inputs.inputs import nothing
from estimator.inputs.moved import moved
from estimator.model import Model
from estimator.record import Recording
from estimator.rig import Rig
from estimator.terms import Link, Store
from estimator.work import Runs

CLOSE = 5e-3  # of the widest
JUDGED = 2  # of the signals, that are judged with the model's own parameters moving
DRIVE = ("speed", "position")
STEADY = 0.01  # of the speed, by which it may differ from the tick before
FEW = 20  # ticks that do not tell how far the table goes
ZERO = "zero of position"
ALL = "all"


@dataclass(frozen=True)
class Scale:
    """Errors of an input: how large they may be, and from where on it is called wrong."""

    widest: float
    sure: float


LOG, KELVIN, MM = Scale(float(np.log(2.5)), 0.05), Scale(10.0, 0.5), Scale(300.0, 10.0)


@dataclass(frozen=True)
class Mislabel:
    """A run whose input, or inputs, are `ratio` times the truth, or `shift_K` or `shift_mm` above it.

    run      its name, ALL: so it is in every recording
    judged   how well the recordings are explained once it is set right
    besides  effects that stand out then
    """

    run: str
    signal: str
    ratio: float
    shift_K: float
    judged: Explanation
    shift_mm: float = 0.0
    besides: tuple[str, ...] = ()


def mislabel(ground: Ground, runs: Runs, trials: Trials, odd: int) -> Mislabel | None:
    """The wrong input of an odd run that explains most, beside a model that suits the others; None if none does."""
    rig, recording, model = runs.rig, runs.recordings[odd], ground.model
    free, known = [Column(model, path) for path in ground.paths], ground.belief(model, ground.paths)
    others = [moments_of(trial, model, free) for i, trial in enumerate(trials) if i != odd]
    wrong = list[Mislabel]()
    for signal, size in _likely(model, rig, recording)[:JUDGED]:
        right = beside(trials[odd], slow_trial(model, rig, corrected(recording, rig, signal, size)))
        judged = Panel(free, [*others, moments_of(right, model, free)], known).judge()
        wrong.append(_mislabel(recording.name, rig, signal, size, judged))
    return min(wrong, key=lambda m: m.judged.misfit, default=None)


def _likely(model: Model, rig: Rig, recording: Recording) -> list[tuple[str, float]]:
    """Signals that may be wrong, each with the size that leaves the model least, best first."""
    trial = Trial(model, rig, recording)
    recording = trial.heard
    told = [name for name in signals(model, rig) if name not in rig.inputs or _open(rig, trial, name)]
    if abs(np.log(gone(recording, rig))) < LOG.sure:
        told = [name for name in told if name not in DRIVE]
    found = [(*_best(model, rig, recording, name), name) for name in told]
    return [(name, size) for left, size, name in sorted(found) if abs(size) >= _scale(rig, name).sure]


def gone(recording: Recording, rig: Rig) -> float:
    """How far the position goes, over how far the screw turns; NaN where that is not told.

    From frame to frame, where these are many; else in ticks of steady speed: the table turns back in some of them, and
    the greatest share, but for a twentieth, is of those in which it does not.
    """
    told = np.abs(recording.pace[np.isfinite(recording.pace)])
    if len(told) > FEW:
        return float(np.median(told))
    if rig.screw is None or not {*DRIVE} <= set(rig.inputs):
        return float("nan")
    went, turned = np.abs(np.diff(recording.inputs["position"])), recording.omega * rig.tick_s
    path, steady = rig.screw.lead_mm / (2 * np.pi) * turned[1:], np.abs(np.diff(turned)) <= STEADY * turned[1:]
    share = went[steady & (path > 0)] / path[steady & (path > 0)]
    known = share[np.isfinite(share)]
    return float(np.quantile(known, 0.95)) if len(known) > FEW else float("nan")


def _open(rig: Rig, trial: Trial, name: str) -> bool:
    """Whether an input was read, and no start has set it right."""
    column = trial.heard.inputs[name]
    right = rig.inputs[name].unit == "degC" and trial.run.start.sets_right(float(column[trial.run.tick]))
    return bool(np.nan_to_num(column).any()) and not right


def _mislabel(run: str, rig: Rig, signal: str, size: float, judged: Explanation) -> Mislabel:
    if signal == ZERO:
        return Mislabel(run, "position", 1.0, 0.0, judged, shift_mm=size)
    if _scale(rig, signal) is KELVIN:
        return Mislabel(run, signal, 1.0, size, judged)
    return Mislabel(run, signal, float(np.exp(size)), 0.0, judged)


def signals(model: Model, rig: Rig) -> list[str]:
    """Inputs of which a wrong scale or shift would matter: temperatures that heat flows to, and all that are none.

    A body of the model's is none of these, though an input of its name says what it starts with. Speed and position may
    be wrong together.
    """
    drive = [name for name in DRIVE if name in rig.inputs]
    both = ["speed and position"] if len(drive) == 2 else []
    terms = list(model.terms(nothing(rig), rig))
    ends = {end for term in terms if isinstance(term, Link) for end in (term.a, term.b)}
    ends -= {term.node for term in terms if isinstance(term, Store)}
    used = [name for name in rig.inputs if name in ends or rig.inputs[name].unit != "degC"]
    zero = [ZERO] if "position" in drive and rig.nut else []
    return [*drive, *both, *zero, *(n for n in used if n not in (*DRIVE, "current", "displacement_direct"))]


def corrected(recording: Recording, rig: Rig, signal: str, size: float) -> Recording:
    """The recording as it would be if the signal were the logarithm `size` of a ratio, or `size` K or mm, too high."""
    if signal == ZERO:
        return _elsewhere(recording, rig, shift_mm=-size)
    if _scale(rig, signal) is KELVIN:
        return replace(recording, inputs={**recording.inputs, signal: recording.inputs[signal] - size})
    share = float(np.exp(-size))
    if signal in (*DRIVE, "speed and position"):
        speed, position = (share if name in signal else 1.0 for name in DRIVE)
        right = _elsewhere(recording, rig, share) if "position" in signal else recording
        return replace(right, omega=recording.omega * speed, pace=recording.pace * position / speed)
    return replace(recording, inputs={**recording.inputs, signal: recording.inputs[signal] * share})


def _elsewhere(recording: Recording, rig: Rig, share: float = 1.0, shift_mm: float = 0.0) -> Recording:
    """The recording if every position p were share p + shift_mm."""
    coverage, stay = (moved(cover, rig, share, shift_mm) for cover in (recording.coverage, recording.stay))
    return replace(recording, coverage=coverage, stay=stay)


def _best(model: Model, rig: Rig, recording: Recording, signal: str) -> tuple[float, float]:
    """What a model leaves of a run at the least, and the logarithm of the ratio, or the shift in K or mm, for that."""

    def misfit(size: float) -> float:
        trial = unjudged(model, rig, corrected(recording, rig, signal, size))
        return Panel([], [moments_of(trial, model, [])]).cost

    widest = _scale(rig, signal).widest
    found = scipy.optimize.minimize_scalar(
        misfit, bounds=(-widest, widest), method="bounded", options={"xatol": CLOSE * widest}
    )
    return float(found.fun), float(found.x)


def _scale(rig: Rig, signal: str) -> Scale:
    """In what an error of this signal is told."""
    if signal == ZERO:
        return MM
    return KELVIN if signal in rig.inputs and rig.inputs[signal].unit == "degC" else LOG
