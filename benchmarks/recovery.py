"""Are true parameters found again, as well as a fit says? A hundred recordings that the model itself has lived.

Each has its own true parameters; its states move with the model's own process noise, unknown zeros are drawn and walk,
and readings scatter as the model says. The fit begins from the defaults.
"""

import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from benchmarks import paper_rig
from benchmarks.fitting import only
from benchmarks.measure import Row, say, table
from estimator.batch.system import System
from estimator.batch.trial import Trial
from estimator.fit.fit import fit
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.state.doubt import root
from estimator.work import Runs

SEEDS = 100
PATHS = ("nut_friction.power", "anchor_friction.power", "free_friction.power", "nut_body.g", "thermometers.tau")
APART = 0.2  # true parameters differ from the defaults by up to this share
AIR_C = 22.0
DRIVES = ((60, 480, 174.5), (780, 960, 120.0))  # from s, to s, rad/s
SECONDS = 1500
STROKE_MM = 400.0
READ_EVERY = 3  # ticks between two displacement readings


@dataclass(frozen=True)
class Recovered:
    """Of one seed: (fitted - true) / sd of each parameter, error as a share of the true value, how the fit ended."""

    off: Array
    share: Array
    raised: float
    converged: bool


def drive(rig: Rig) -> Recording:
    """Rest, a drive to and fro over the stroke, rest, a slower drive, rest; no channel read but in the first sample."""
    screw, nut = rig.the_screw(), rig.the_nut()
    time_s, omega = np.arange(SECONDS) + 1.0, np.zeros(SECONDS)
    for begin, end, speed in DRIVES:
        omega[begin:end] = speed
    fine = np.repeat(omega, 40) / 40
    way = np.cumsum(fine) / (2 * np.pi) * screw.lead_mm
    position = (STROKE_MM - np.abs(STROKE_MM - way % (2 * STROKE_MM))).reshape(-1, 40)
    centre, half = nut.centre(position), nut.length_mm / 2
    coverage = screw.overlap(centre - half, centre + half).mean(axis=1)
    inputs = {name: np.full(SECONDS, AIR_C if signal.unit == "degC" else 0.0) for name, signal in rig.inputs.items()}
    inputs["position"] = position[:, -1]
    channels = np.zeros((SECONDS, len(rig.names)))
    channels[0] = np.where(rig.is_thermometer, AIR_C, 0.0)
    return Recording("simulated", time_s, channels, np.zeros_like(channels), inputs, omega, coverage)


def lived(model: Model, rig: Rig, run: Recording, dice: np.random.Generator) -> Recording:
    """What the channels read of this run, drawn from the model as the filter takes it."""
    system = Trial(model, rig, run, gated=False).pose(model).system
    x, readings = dice.multivariate_normal(system.x0, system.P0, method="eigh"), np.empty_like(system.y)
    shake = [root(Q) for Q in system.Q]
    d = system.F.shape[1]
    for t, regime in enumerate(system.regime):
        x = np.append(system.F[regime] @ x[:d], x[d:]) + system.b[t] + shake[regime] @ dice.standard_normal(len(x))
        readings[t] = _rows(system, t) @ x
    beside = run.channels[1:] - system.y  # offsets, lags
    scatter = np.sqrt(system.R) * dice.standard_normal(system.R.shape)
    channels = np.vstack([run.channels[:1], readings + beside + scatter])
    unread = np.arange(len(channels)) % READ_EVERY > 0
    channels[np.ix_(unread, system.spans > 0)] = np.nan
    return replace(run, channels=channels)


def _rows(system: System, t: int) -> Array:
    rows = system.H.copy()
    rows[:, system.column] += system.spans * system.grown[t]
    return rows


def one(seed: int) -> Recovered:
    """Draw parameters, live, fit."""
    dice = np.random.default_rng(seed)
    rig, start = paper_rig.rig(), only(paper_rig.model(), PATHS)
    true = {path: start[path] * dice.uniform(1 - APART, 1 + APART) for path in PATHS}
    found = fit(start, Runs(rig, [lived(start.with_values(true), rig, drive(rig), dice)]))
    by_path = {f.path: f for f in found.parameters}
    fitted, sd = (np.array([getattr(by_path[path], key) for path in PATHS]) for key in ("value", "sd"))
    wanted = np.array([true[path] for path in PATHS])
    return Recovered((fitted - wanted) / sd, (fitted - wanted) / wanted, found.raised.others, found.converged)


def markdown() -> str:
    """Fit every seed; the table."""
    began, found = perf_counter(), []
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for done, each in enumerate(pool.map(one, range(SEEDS)), start=1):
            found.append(each)
            say(f"  {done} of {SEEDS}: {np.round(each.off, 1)} sd")
    return table(f"Recovery: {SEEDS} recordings that the model has lived", _table(found), _says(perf_counter() - began))


def _table(found: Sequence[Recovered]) -> list[Row]:
    off = np.abs([each.off for each in found])
    share = np.array([each.share for each in found])
    within = {k: float((off < k).mean()) for k in (1, 2, 3)}
    raised = [each.raised for each in found]
    rows = [
        Row("parameters within 3 sd of the truth", f"{within[3]:.1%}", within[3], 0.95, least=True),
        Row("within 2 sd (normal: 95.4%)", f"{within[2]:.1%}"),
        Row("within 1 sd (normal: 68.3%)", f"{within[1]:.1%}"),
    ]
    for i, path in enumerate(PATHS):
        text = f"{(off[:, i] < 2).mean():.0%} within 2 sd, {(off[:, i] < 3).mean():.0%} within 3 sd, error rms"
        rows.append(Row(path, f"{text} {np.sqrt(np.mean(share[:, i] ** 2)):.2%}, mean {share[:, i].mean():+.2%}"))
    return [
        *rows,
        Row("fits that converged", str(sum(each.converged for each in found))),
        Row("fits that raised the process noise", f"{sum(r > 1 for r in raised)}, at most {max(raised):.2f} times"),
    ]


def _says(seconds: float) -> list[str]:
    drives = " and ".join(f"{begin} .. {end} s" for begin, end, _ in DRIVES)
    return [
        f"{SECONDS / 60:.0f} min each, driven {drives}; {len(PATHS)} parameters drawn evenly within {APART:.0%} of "
        f"their defaults, then fitted from there. {seconds:.0f} s in {os.cpu_count()} processes."
    ]
