"""One machine: a model fitted to some of its runs and judged against the truth of the others.

Judged are the elongation in every situation, the end of blind minutes, and the temperatures where the thermometers are.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ballscrew.muting import muted
from benchmarks import handed_over, paper_rig
from benchmarks.accuracy import SITUATIONS, mute_in
from benchmarks.machine_truth import run_of, true_parameters
from benchmarks.measure import numbers, say, timed
from drivers.virtual_rig import Run
from drivers.virtual_rig.population.draw import machine
from drivers.virtual_rig.protocol import EXPERIMENTS
from estimator.batch.replay import replay
from estimator.fit.fit import Fit, fit
from estimator.fit.tune import tune
from estimator.inputs.phase import COOLDOWN_S, cooling, phases, stops, turns
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.step import Track
from estimator.work import Runs

FIRST = next(iter(SITUATIONS))  # all channels: blind minutes and temperatures are judged here
BLIND_MIN = (10, 60)
JUDGED_ON = range(101, 121)  # whatever is chosen by a result is chosen on machines 1 - 20
FITS = {
    "four": ("FS-20", "FS-5", "CS-10", "ES-2.5"),
    "three": ("FS-20", "CS-10", "ES-5"),
    "one": ("FS-20",),
    "two": ("FS-20", "CS-5"),
    "eight": ("FS-20", "FS-5", "CS-10", "ES-2.5", "FS-2.5", "CS-20", "CS-5", "ES-20"),
}
WORDS = {"three": ("three",), "runs": ("one", "two", "four", "eight")}


@dataclass(frozen=True)
class Case:
    """A machine, to which of its runs the model is fitted (FITS), and the situations in which it is judged."""

    machine: int
    fit: str
    situations: tuple[str, ...]


def asked(words: Sequence[str]) -> list[Case]:
    """The cases that words ask for; without any: all machines that judge, fitted to four runs."""
    machines = [n for word in words for n in numbers(word)] or list(JUDGED_ON)
    fits = [name for word in words for name in WORDS.get(word, ())] or ["four"]
    situations = tuple(SITUATIONS)[: 1 if "quick" in words else None]
    if unknown := [word for word in words if word not in (*WORDS, "quick") and not numbers(word)]:
        known = ", ".join((*WORDS, "quick"))
        raise SystemExit(f"machines: what is {', '.join(unknown)}? Numbers of machines like 1-4, or {known}")
    return [Case(number, name, situations) for name in fits for number in machines]


def study(case: Case) -> dict[str, Any]:
    """Fit and judge one machine; as JSON holds it."""
    rig, own, fitted_on = paper_rig.rig(), machine(case.machine), FITS[case.fit]
    runs = Runs(rig, [handed_over.record(run_of(case.machine, name), rig) for name in fitted_on])
    found, fit_s, _ = timed(lambda: fit(paper_rig.model(), runs))
    say(f"  machine {case.machine}: fitted to {case.fit}, {fit_s:.0f} s")
    tuned, tune_s, _ = timed(lambda: tune(found.model, runs))
    say(f"  machine {case.machine}: tuned, {tune_s:.0f} s")
    held_out = [name for name in EXPERIMENTS if name not in fitted_on]
    return {
        "laws": own.laws,
        "fit_s": fit_s,
        "tune_s": tune_s,
        "converged": found.converged,
        "raised": vars(found.raised),
        "noise": {key: by * vars(tuned.factors)[key] for key, by in vars(found.raised).items()},
        "parameters": against(found, true_parameters(own)),
        "runs": {name: judge(run_of(case.machine, name), tuned.model, rig, case.situations) for name in held_out},
    }


def against(found: Fit, true: dict[str, float]) -> dict[str, dict[str, float]]:
    """Fitted parameters that have a true value: what was found, its sd, and how many of these it is off."""
    return {
        p.path: {"true": true[p.path], "value": p.value, "sd": p.sd, "off": (p.value - true[p.path]) / p.sd}
        for p in found.parameters
        if p.path in true and p.sd > 0.0
    }


@dataclass(frozen=True)
class Judged:
    """Elongation of a run, reference minus estimate, over the ticks after the first.

    um           lowest and highest error;   cooldown_um: largest in the 60 min after stops
    in_2sd       share of ticks with the truth within 2 sd;   cooldown_in_2sd: of those in the 60 min after stops
    nees         mean of (error / sd)^2, 1: as large as the sd says
    """

    um: tuple[float, float]
    cooldown_um: float
    in_2sd: float
    cooldown_in_2sd: float
    nees: float
    ticks: int


def judged(error: Array, sd: Array, late: Array) -> Judged:
    """Errors (K,) um with their sd; `late` (K,) bool: within an hour after a stop."""
    z = error / sd
    inside = np.abs(z) <= 2.0
    return Judged(
        um=(float(error.min()), float(error.max())),
        cooldown_um=float(np.abs(error[late]).max()),
        in_2sd=float(inside.mean()),
        cooldown_in_2sd=float(inside[late].mean()),
        nees=float((z**2).mean()),
        ticks=len(error),
    )


def judge(run: Run, model: Model, rig: Rig, situations: Sequence[str]) -> dict[str, Any]:
    """A run in some situations, as JSON holds it; in the first also blind minutes and the thermometers' places."""
    recording, found = handed_over.record(run, rig), {}
    true_um = np.interp(recording.time_s, run.truth.time_s, run.truth.elongation_um)
    late = cooling(recording)
    for situation in situations:
        track = replay(model, rig, recording, mute_in(situation, recording, rig))
        now = (np.cumsum(track.begins) > 0) & ~track.begins
        error = true_um - track.elongation_um
        found[situation] = asdict(judged(error[now], track.sigma_um[now], late[now]))
        if situation == FIRST:
            found["temperatures"] = temperatures(run, recording, rig, track)
    if FIRST in situations:
        found["blind"] = {f"{m} min": blind(recording, true_um, model, rig, 60.0 * m) for m in BLIND_MIN}
    return found


def temperatures(run: Run, recording: Recording, rig: Rig, track: Track) -> dict[str, float]:
    """Share of the true rises of the wall at the thermometers that are within 2 sd, driving and at rest.

    The estimated profile is that of the sections' means. It is smooth, and bends within the distance of its places: a
    spline between them. The wall of the bore is cooler where heat goes on along the axis.
    """
    places = np.array([rig.channels[name].at_mm for name in rig.thermometers], float)
    began = int(np.flatnonzero(track.begins)[-1])
    profile = CubicSpline(track.x_mm, track.profile_C[began:], axis=1)
    found = profile(places) + rig.the_screw().bore_mm2 * profile(places, 2)
    sd = np.array([np.interp(places, track.x_mm, row) for row in track.profile_sd_K[began:]])
    time_s, truth = recording.time_s[began:], run.truth
    rises = np.column_stack([np.interp(time_s, truth.time_s, column) for column in truth.rises.T])
    inside, driving = np.abs(found - found[0] - (rises - rises[0])) <= 2.0 * sd, turns(recording.omega[began:])
    return {"driving": float(inside[driving].mean()), "at rest": float(inside[~driving].mean())}


def blind(recording: Recording, true_um: Array, model: Model, rig: Rig, seconds: float) -> list[float]:
    """(error / sd) of the elongation at the end of each span in which nothing was read."""
    spans = blind_spans(recording, seconds)
    texts = [f"{name}:{begin:.0f}-{end:.0f}" for begin, end in spans for name in ("telemeter", "displacement")]
    track = replay(model, rig, recording, muted(recording, rig, None, False, texts))
    since = recording.time_s - recording.time_s[0]
    last = [int(np.searchsorted(since, round(end), side="right")) - 1 for _, end in spans]
    return [float((true_um[k] - track.elongation_um[k]) / track.sigma_um[k]) for k in last]


def blind_spans(recording: Recording, seconds: float) -> list[tuple[float, float]]:
    """From the middle of the first drive on, and in the middle of the last hour after a stop; s since the start."""
    start = float(recording.time_s[0])
    drive = next(ticks for driving, ticks in phases(recording) if driving)
    middle = float(recording.time_s[drive[len(drive) // 2]]) - start
    rest = stops(recording)[-1] - start + (COOLDOWN_S - seconds) / 2.0
    return [(middle, middle + seconds), (rest, min(rest + seconds, float(recording.time_s[-1]) - start))]
