"""A monitor restarted at random, in mid-drive and in cooldown, 2 s to 30 min later: what becomes of the zero."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks import paper_rig
from benchmarks.measure import section
from drivers.logs.truth import read_truth
from estimator.batch.replay import replay
from estimator.record import Array, Recording

RUNS = ("FS-20", "CS-20", "ES-20", "FS-10", "CS-10", "ES-10", "FS-5", "CS-5", "ES-5", "ES-2.5")
SEED, WITHIN_UM = 1, 0.2
GAP_S = (2.0, 1800.0)
LEFT = 600  # ticks that are looked at after a restart
WAYS = ("goes on with the recording", "begins anew, by zero_C", "begins anew")


@dataclass(frozen=True)
class Restart:
    """After one restart: reference minus estimate, and the sd, each (ticks,) um."""

    error: Array
    sd: Array

    @property
    def beyond(self) -> float:
        """By how much it is off by more than 0.2 um and two standard deviations, at most."""
        return float((np.abs(self.error) - WITHIN_UM - 2.0 * self.sd).max())


def markdown() -> str:
    """A row for each way to start again, while driving and at rest."""
    dice, rows = np.random.default_rng(SEED), []
    for driving in (True, False):
        made = [_restarts(name, driving, dice) for name in RUNS]
        for way, found in zip(WAYS, zip(*made, strict=True), strict=True):
            rows.append([f"{'in mid-drive' if driving else 'in cooldown'}, {way}", *_cells(found)])
    head = ["restart", "first tick, worst, um", "its sd", "60 s later, worst, um", "its sd", "beyond 0.2 um + 2 sd"]
    said = f"{2 * len(RUNS)} restarts at random, nothing heard for {GAP_S[0]:g} s to {GAP_S[1] / 60:g} min, then 10 min"
    return section("The zero after a restart of the monitor", [head, *rows], [f"{said} against the truth."])


def _cells(found: Sequence[Restart]) -> list[str]:
    cells = []
    for k in (0, 60):
        cells += [f"{max(abs(one.error[k]) for one in found):.2f}", f"{max(one.sd[k] for one in found):.2f}"]
    return [*cells, f"{sum(one.beyond > 0 for one in found)} of {len(found)}"]


def _restarts(name: str, driving: bool, dice: np.random.Generator) -> list[Restart]:
    """One restart in a run, in each of the ways."""
    recording, rig, model = paper_rig.recording(name), paper_rig.rig(), paper_rig.model()
    true_um = read_truth(paper_rig.path_of(name)).at(recording.time_s)
    cold_C = float(np.nanmean(recording.channels[:5, rig.is_thermometer]))
    inside = np.arange(60, len(recording) - 2 * LEFT)
    at = int(dice.choice(inside[(recording.omega[inside] > 0) == driving]))
    end = min(at + round(np.exp(dice.uniform(*np.log(GAP_S)))), len(recording) - LEFT)
    after = slice(end, end + LEFT)
    tracks = [replay(model, rig, _silent(recording.rows(slice(end + LEFT)), slice(at, end)))]
    tracks += [replay(model, each, recording.rows(after)) for each in (replace(rig, zero_C=cold_C), rig)]
    return [Restart(true_um[after] - t.elongation_um[-LEFT:], t.sigma_um[-LEFT:]) for t in tracks]


def _silent(recording: Recording, gap: slice) -> Recording:
    """The recording with nothing heard in a gap."""
    heard = np.ones(len(recording), dtype=bool)
    heard[gap] = False

    def lost(rows: Array) -> Array:
        return np.where(heard.reshape(-1, *[1] * (rows.ndim - 1)), rows, np.nan)

    inputs = {name: lost(column) for name, column in recording.inputs.items()}
    return replace(
        recording, channels=lost(recording.channels), inputs=inputs, omega=lost(recording.omega),
        coverage=lost(recording.coverage),
    )  # fmt: skip
