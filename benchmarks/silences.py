"""Silences of the telemeter on machines that are not the model's: who is said to have jumped when it is read again."""

from dataclasses import replace

import numpy as np

from benchmarks import handed_over, paper_rig, sound
from benchmarks.measure import say, section
from estimator.batch.replay import replay
from estimator.faults.fault import Fault
from estimator.record import Array

GAPS = (("FS-20", 300.0, 700.0), ("CS-20", 300.0, 900.0), ("CS-20", 200.0, 500.0), ("ES-10", 400.0, 1500.0))
TOLD_S, AFTER_S = 60.0, 900.0  # after it is read again: until who has jumped is told; over which errors are taken
HEAD = ("machine", "run", "silent, s", "thermometers accused", "worst, um", "without the silence", "in 2 sd")


def table(seed: int) -> str:
    """Each gap on each machine, by the model of machine 0."""
    rows = (_row(number, *gap, seed) for number in sound.OTHERS for gap in GAPS)
    return section("Silences of the telemeter, another machine", [HEAD, *rows], level=3)


def _row(number: int, run: str, from_s: float, to_s: float, seed: int) -> list[str]:
    rig, model = paper_rig.rig(), paper_rig.model()
    recording, true_um = handed_over.simulated(run, rig, machine=number, seed=seed)
    silent = (recording.time_s > from_s) & (recording.time_s < to_s)
    readings = np.where(silent[:, None] & rig.is_thermometer, np.nan, recording.channels)
    track = replay(model, rig, replace(recording, channels=readings))
    after_s = track.time_s - to_s
    told, now = (after_s >= 0.0) & (after_s < TOLD_S), (after_s >= 0.0) & (after_s < AFTER_S)
    accused = (track.fault[told][:, rig.is_thermometer] > Fault.JUDGED).any(axis=0).sum()
    error = abs(true_um - track.elongation_um)[now]
    in_2sd = (error <= 2.0 * track.sigma_um[now]).mean()
    say(f"  machine {number}, {run}, silent from {from_s:.0f} s: {accused} accused, {error.max():.2f} um")
    usual = _worst(true_um, replay(model, rig, recording).elongation_um, now)
    between = f"{from_s:.0f} - {to_s:.0f}"
    return [f"{number}", run, between, f"{accused}", f"{error.max():.2f}", f"{usual:.2f}", f"{in_2sd:.0%}"]


def _worst(true_um: Array, estimate_um: Array, now: Array) -> float:
    return float(abs(true_um - estimate_um)[now].max())
