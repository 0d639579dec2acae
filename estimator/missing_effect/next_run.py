"""The run that would tell rivals apart: how far their predictions differ on runs that were not made yet.

    D2 = min over changes d of b's parameters of  d' C d + misfit of b, so changed, to what a predicts

C is the curvature that the recordings at hand leave: rival b may move its parameters as far as they allow. D is by how
many standard deviations the new run sets the rivals apart.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from estimator.batch.kernels import coast
from estimator.batch.nominal import open_loop
from estimator.batch.trial import Trial
from estimator.batch.trials import slow_trials_of
from estimator.hypotheses.hypothesis import Hypothesis
from estimator.hypotheses.moments import Column, moments_of
from estimator.hypotheses.panel import Panel
from estimator.inputs.phase import speed_of, turns
from estimator.inputs.start import Start
from estimator.model import Model
from estimator.network.forcing import Forcing
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.work import Runs

PATTERNS = {"FS": (0.0, 1.0), "CS": (0.325, 0.6075), "ES": (0.505, 0.7875)}  # parts of the travel seen so far
TICK_S = 5.0
REST_S, STOP_S = 60.0, 3600.0
DRIVES_S = (600.0, 1800.0, 3600.0)


@dataclass(frozen=True)
class NextRun:
    """A run to make, and by how many sd it sets two rivals apart; the stroke in mm of the table."""

    pattern: str
    stroke_mm: tuple[float, float]
    speed_m_min: float
    drive_s: float
    stop_s: float
    separation_sd: float


def next_run(a: Hypothesis, b: Hypothesis, runs: Runs) -> NextRun | None:
    """The run that sets two rivals furthest apart; None on a rig that does not travel."""
    rig, recordings = runs.rig, runs.recordings
    if rig.nut is None or rig.screw is None or not {"speed", "position"} <= set(rig.inputs):
        return None
    slow, laws = replace(rig, tick_s=TICK_S), learned(recordings, rig)
    level = float(np.nanmedian([np.nanmedian(r.channels[0]) for r in recordings]))
    columns = [Column(b.model, path) for path in b.paths]
    known = Panel.of(slow_trials_of(b.model, runs), b.model, columns, b.ground.belief(b.model, b.paths))
    plans = list(_plans(rig, recordings))
    if not plans:
        return None
    apart = list(runs.workers(lambda plan: _apart(a.model, b.model, plan, slow, level, laws, known), plans))
    best = int(np.argmax(apart))
    return replace(plans[best], separation_sd=float(apart[best]))


def _plans(rig: Rig, recordings: Sequence[Recording]) -> Iterator[NextRun]:
    """Patterns, speeds and drive times to choose from, inside the travel and the speeds seen so far."""
    moving = [r.inputs["position"][turns(r.omega)] for r in recordings]
    places = np.concatenate(moving)
    places = places[np.isfinite(places)]
    speeds = sorted({float(v) for r in recordings for v in speed_of(r, rig)} - {0.0})
    if not len(places) or not speeds:
        return
    lo, travel = float(places.min()), float(np.ptp(places))
    for pattern, (begin, end) in PATTERNS.items():
        stroke = (lo + begin * travel, lo + end * travel)
        for speed in sorted({speeds[0], speeds[len(speeds) // 2], speeds[-1]}):
            for drive in DRIVES_S:
                yield NextRun(pattern, stroke, speed, drive, STOP_S, 0.0)


def _run(plan: NextRun, rig: Rig, level: float) -> Recording:
    """The plan as a recording without readings, all inputs at the level."""
    assert rig.nut is not None
    screw = rig.the_screw()
    time_s = np.arange(0.0, REST_S + plan.drive_s + plan.stop_s, rig.tick_s)
    driving = (time_s > REST_S) & (time_s <= REST_S + plan.drive_s)
    omega = np.where(driving, plan.speed_m_min / 60 / (screw.lead_mm * 1e-3) * 2 * np.pi, 0.0)
    centre = rig.nut.centre(np.linspace(*plan.stroke_mm, 50))
    cover = screw.overlap(centre - rig.nut.length_mm / 2, centre + rig.nut.length_mm / 2)
    coverage = np.where(driving[:, None], cover.mean(axis=0), cover[0])
    none = np.full((len(time_s), len(rig.names)), np.nan)
    inputs = {n: np.full(len(time_s), level if s.unit == "degC" else 0.0) for n, s in rig.inputs.items()}
    inputs["position"] = np.full(len(time_s), plan.stroke_mm[0])
    return Recording("planned", time_s, none, np.zeros_like(none), inputs, omega, coverage)


def _lived(model: Model, run: Recording, rig: Rig, level: float) -> Recording:
    """The run as the model foretells it; the displacement is read while driving."""
    forcing = Forcing(model, rig, Start(level, 0.0, dict.fromkeys(rig.inputs, 0.0)))
    start = np.full(forcing.place.size, level)
    channels = open_loop(forcing, forcing.read(run), start, run.ages_s)
    for i, name in enumerate(rig.names):
        if name not in rig.thermometers:
            channels[run.omega == 0, i] = np.nan
    return replace(run, channels=channels)


def _apart(a: Model, b: Model, plan: NextRun, rig: Rig, level: float, laws: dict[str, Array], known: Panel) -> float:
    """How many sd a run sets two rivals apart."""
    run = _run(plan, rig, level)
    first = _lived(a, run, rig, level)
    heat = [rig.index(name) for name in rig.thermometers]
    rises = foretold(laws, np.nan_to_num(np.nanmean(first.channels[:, heat], axis=1) - level), run.omega, rig.tick_s)
    run = replace(run, inputs={**run.inputs, **{name: level + rise for name, rise in rises.items()}})
    trial = Trial(b, rig, _lived(a, run, rig, level), gated=False)
    return known.with_another(moments_of(trial, b, known.columns))


def learned(recordings: Sequence[Recording], rig: Rig) -> dict[str, Array]:
    """(a, c, b) of every temperature that is an input, in 1/s."""
    return {name: _law(recordings, rig, name) for name, signal in rig.inputs.items() if signal.unit == "degC"}


def foretold(laws: Mapping[str, Array], mean_rise: Array, omega: Array, tick_s: float) -> dict[str, Array]:
    """Rise of each input, (K,), on a run with this mean rise of the thermometers and this speed."""
    out = {}
    for name, (a, c, b) in laws.items():
        drive = (a * mean_rise + c * omega) * tick_s
        kept = np.full((1, 1, 1), np.exp(-max(b, 0.0) * tick_s))
        out[name] = coast(kept, np.zeros(len(drive)), drive[:, None], np.zeros(1))[:, 0]
    return out


def _law(recordings: Sequence[Recording], rig: Rig, name: str) -> Array:
    rows, rises = [], []
    heat = [rig.index(each) for each in rig.thermometers]
    for recording in recordings:
        r, m = _rise(recording.inputs[name]), np.nan_to_num(_rise(np.nanmean(recording.channels[:, heat], axis=1)))
        sums = np.cumsum([m, np.nan_to_num(recording.omega), -np.nan_to_num(r)], axis=1) * rig.tick_s
        known = np.isfinite(r)
        rows.append(sums[:, known].T)
        rises.append(r[known])
    stacked = np.concatenate(rows)
    if not len(stacked):
        return np.zeros(3)
    return np.asarray(np.linalg.lstsq(stacked, np.concatenate(rises), rcond=None)[0])


def _rise(column: Array) -> Array:
    known = column[np.isfinite(column)]
    return column - (known[:10].mean() if len(known) else np.nan)
