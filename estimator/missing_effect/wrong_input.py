"""Whether one recording among several has a wrong input: a speed in other units, a label, a shifted thermometer.

The run that the model misses most, while it suits the others, is asked: is there a ratio of one of its inputs, or a
shift of a temperature, with which the model suits this run as well?
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from estimator.batch.trial import Trial
from estimator.batch.trials import Trials, slow_trial, unjudged
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.moments import Column, moments, moments_of
from estimator.hypotheses.panel import Explanation, Panel
from estimator.inputs.inputs import nothing
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.terms import Link
from estimator.work import Runs

ODD = 3.0  # times the other runs' misfit makes a run odd ...
BAD = 2.0  # ... if it is no good model either
WIDEST = np.log(2.5)
SHIFT_K = 10.0
SURE = 0.05  # a ratio closer to 1 is no wrong label
SURE_K = 0.5
CLOSE = 5e-3
DRIVE = ("speed", "position")


@dataclass(frozen=True)
class Mislabel:
    """A run whose input, or inputs, are `ratio` times the truth or `shift_K` above it; the misfit once set right."""

    run: str
    signal: str
    ratio: float
    shift_K: float
    judged: Explanation


def mislabel(ground: Ground, runs: Runs, trials: Trials) -> Mislabel | None:
    """The wrong input of the oddest run that explains most; None where no run is odd, or none explains it."""
    rig, recordings, model = runs.rig, runs.recordings, ground.model
    if len(recordings) < 3:
        return None
    free, known = [Column(model, path) for path in ground.paths], ground.belief(model, ground.paths)
    found = moments(trials, model, free)
    misfits = Panel(free, found, known).judge().runs
    odd = int(misfits.argmax())
    if misfits[odd] < max(BAD, ODD * float(np.median(np.delete(misfits, odd)))):
        return None
    recording, others = recordings[odd], [*found[:odd], *found[odd + 1 :]]
    suited = Panel(free, others, known)
    by_others = model.with_values(suited.values(suited.judge()))
    heard, wrong = Trial(by_others, rig, recording).heard, list[Mislabel]()
    for signal in signals(model, rig):
        if signal in rig.inputs and not np.nan_to_num(recording.inputs[signal]).any():
            continue
        size, shift = _best(by_others, rig, heard, signal), _is_shift(rig, signal)
        if abs(size) >= (SURE_K if shift else SURE):
            right = slow_trial(model, rig, corrected(recording, rig, signal, size))
            judged = Panel(free, [*others, moments_of(right, model, free)], known).judge()
            ratio, shift_K = (1.0, size) if shift else (float(np.exp(size)), 0.0)
            wrong.append(Mislabel(recording.name, signal, ratio, shift_K, judged))
    return min(wrong, key=lambda m: m.judged.misfit, default=None)


def signals(model: Model, rig: Rig) -> list[str]:
    """Inputs of which a wrong scale or shift would matter: temperatures that heat flows to, and all that are none.

    Speed and position may be wrong together.
    """
    drive = [name for name in DRIVE if name in rig.inputs]
    both = ["speed and position"] if len(drive) == 2 else []
    ends = {end for term in model.terms(nothing(rig), rig) if isinstance(term, Link) for end in (term.a, term.b)}
    used = [name for name in rig.inputs if name in ends or rig.inputs[name].unit != "degC"]
    return [*drive, *both, *(n for n in used if n not in (*DRIVE, "current", "displacement_direct"))]


def corrected(recording: Recording, rig: Rig, signal: str, size: float) -> Recording:
    """The recording as it would be if the signal were the logarithm `size` of a ratio, or `size` K, too high."""
    if _is_shift(rig, signal):
        return replace(recording, inputs={**recording.inputs, signal: recording.inputs[signal] - size})
    share = float(np.exp(-size))
    if signal in (*DRIVE, "speed and position"):
        omega = recording.omega * (share if "speed" in signal else 1.0)
        coverage = recording.coverage if "position" not in signal else _moved(recording.coverage, rig, share)
        return replace(recording, omega=omega, coverage=coverage)
    return replace(recording, inputs={**recording.inputs, signal: recording.inputs[signal] * share})


def _moved(coverage: Array, rig: Rig, share: float) -> Array:
    """Coverage if every position were `share` of what it is: each cell looks where it would have been."""
    screw, nut = rig.the_screw(), rig.the_nut()
    came_from = nut.centre_mm + (screw.x_mm - nut.centre_mm) / share
    place = np.clip((came_from - screw.x_mm[0]) / (screw.length * 1e3), 0, screw.cells - 1)
    left = np.minimum(place.astype(int), screw.cells - 2)
    part = place - left
    moved = coverage[:, left] * (1 - part) + coverage[:, left + 1] * part
    total = coverage.sum(axis=1, keepdims=True)
    now = moved.sum(axis=1, keepdims=True)
    return np.asarray(moved * np.divide(total, now, out=np.ones_like(now), where=now > 0))


def _best(model: Model, rig: Rig, recording: Recording, signal: str) -> float:
    """Logarithm of the ratio, or shift in K, with which a model suits a run best."""

    def misfit(size: float) -> float:
        trial = unjudged(model, rig, corrected(recording, rig, signal, size))
        return Panel([], [moments_of(trial, model, [])]).cost

    widest = SHIFT_K if _is_shift(rig, signal) else WIDEST
    return float(minimize_scalar(misfit, bounds=(-widest, widest), method="bounded", options={"xatol": CLOSE}).x)


def _is_shift(rig: Rig, signal: str) -> bool:
    """Whether an error of this signal is a shift: of a temperature."""
    return signal in rig.inputs and rig.inputs[signal].unit == "degC"
