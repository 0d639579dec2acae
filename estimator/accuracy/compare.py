"""How far models are from measurements, beside each other: by horizon, channel, phase and speed.

One-step errors flatter: process noise lets a filter follow what its model does not explain. So open-loop and
ten-minutes-ahead errors stand beside them, and the noise floor of the sensors beside those.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.accuracy.accuracy import rms
from estimator.accuracy.horizon import HORIZONS, Horizons, horizons, overall
from estimator.accuracy.machine import Match, off_sd
from estimator.accuracy.noise_floor import FAR, Error, noise_floor
from estimator.batch.trials import trials_of
from estimator.faults.use import Use
from estimator.inputs.phase import PHASES, phase_of, speed_of
from estimator.model import Model
from estimator.record import Array
from estimator.work import Runs, one_thread

ByHorizon = Mapping[str, Error]


@dataclass(frozen=True)
class Comparison:
    """Errors of one model on some recordings; `held_out`: those of the recordings that it was not fitted to, or None.

    by_channel  error of each channel by horizon, in the channel's unit
    by_speed    by mean speed in m/min, of the drive that a tick belongs to or follows
    floor       what the sensors alone would leave
    truths      of how many recordings the true elongation was known, of `recordings`
    match       whether the model is that of the machine
    uses        what was used of each recording by the model's filter
    """

    name: str
    whole: ByHorizon
    held_out: ByHorizon | None
    by_channel: Mapping[str, Mapping[str, float]]
    by_phase: Mapping[str, ByHorizon]
    by_speed: Mapping[float, ByHorizon]
    floor: Error
    warnings: tuple[str, ...]
    truths: int
    recordings: int
    match: Match
    uses: tuple[Use, ...]

    def __repr__(self) -> str:
        """Its errors by horizon, rms."""
        return "\n".join([f"{self.name}: rms", *(f"  {name:12} {error}" for name, error in self.whole.items())])


@one_thread
def compare(model: Model, runs: Runs, truths: Sequence[Array | None] | None = None) -> Comparison:
    """Judge one model on recordings.

    truths  true elongation at the ticks, (K,) um, of those for which it is known. Else the elongation is compared
            with the readings while driving, and at rest with the direct reading, joined at the stop
    """
    rig, recordings, trials = runs.rig, runs.recordings, trials_of(model, runs)
    truths = truths or [None] * len(recordings)
    pairs = list(zip(trials, truths, strict=True))
    found: list[Horizons] = list(runs.workers(lambda pair: horizons(pair[0], model, pair[1]), pairs))
    known = set(model.about.get("fitted_on", {}).values())
    rest = [each for each, r in zip(found, recordings, strict=True) if r.fingerprint not in known]
    whole, floor = _by_horizon(found), noise_floor(model, trials[0])
    phases = [phase_of(trial.rest) for trial in trials]
    speeds = [speed_of(trial.recording, rig)[trial.begin :] for trial in trials]
    levels = sorted(set(np.concatenate(speeds)) - {0.0})
    return Comparison(
        model.name,
        whole,
        _by_horizon(rest) if known and rest else None,
        {
            name: {h: rms(np.concatenate([getattr(e, h)[:, i] for e in found])) for h in HORIZONS}
            for i, name in enumerate(rig.names)
        },
        {phase: _by_horizon(_where(found, [p == phase for p in phases])) for phase in PHASES},
        {float(level): _by_horizon(_where(found, [s == level for s in speeds])) for level in levels},
        floor,
        _warnings(whole, floor),
        sum(truth is not None for truth in truths),
        len(recordings),
        Match(trials.each(lambda trial: off_sd(model, trial, trial.use))),
        trials.uses,
    )


def _by_horizon(found: Sequence[Horizons]) -> ByHorizon:
    return {name: overall(found, name) for name in HORIZONS}


def _where(found: Sequence[Horizons], masks: Sequence[Array]) -> list[Horizons]:
    """The same errors at some of the ticks."""
    return [each.where(at) for each, at in zip(found, masks, strict=True)]


def _warnings(whole: ByHorizon, floor: Error) -> tuple[str, ...]:
    """Said where process noise is what makes a model look good."""
    near, alone = whole["one_step"].temperature_K, whole["open_loop"].temperature_K
    if alone > FAR * floor.temperature_K and near < FAR * floor.temperature_K:
        return (
            f"one tick ahead {near:.3f} K looks fine, but the model alone is {alone:.2f} K off, {alone / near:.0f}"
            " times as much: the readings hide what it does not explain",
        )
    return ()
