"""Thermometers that jump whenever the drive starts or stops: no fault, which comes when it likes, but a law.

What reads more while the screw turns is left out as one that has jumped; who looks for what is missing must hear it, or
never finds the law. So it is with one that drifts in every run, and reads right again at the start of the next.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from estimator.faults.fault import Fault
from estimator.faults.use import ChannelUse, Use
from estimator.inputs.phase import phases
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.work import Runs

NEAR_S = 60.0  # of a start or stop: within that a jump is seen; around four of them it is a fifteenth of two hours
RECORDINGS = 2  # with jumps, and none elsewhere, that chance makes in one of two hundred


def in_step(uses: Sequence[Use], recordings: Sequence[Recording], rig: Rig) -> list[str]:
    """Names of thermometers that have jumped at starts and stops of the drive, in two recordings or more, alone."""
    changes = [_changes(recording) for recording in recordings]
    return [name for name in rig.thermometers if _keeps_step(name, uses, changes)]


def drifts_always(uses: Sequence[Use], rig: Rig) -> list[str]:
    """Names of thermometers that were left out because they drift, in two recordings or more and in most of them.

    What is broken stays so; what goes and comes back with every run may follow something. None where half of them do:
    then it is the model that drifts.
    """
    drifts = [{one.channel for one in use.channels if Fault.DRIFTING in [s.fault for s in one.spells]} for use in uses]
    often = {name: sum(name in some for some in drifts) for name in rig.thermometers}
    found = [name for name, times in often.items() if times >= RECORDINGS and times > len(uses) / 2]
    return found if len(found) < len(often) / 2 else []


def silenced(runs: Runs, names: Sequence[str]) -> Runs:
    """The runs as if some thermometers had never been read; still told again as what a model was fitted to."""
    kept = ~np.isin(runs.rig.names, list(names))
    some = [
        replace(each, channels=np.where(kept, each.channels, np.nan), part_of=each.fingerprint)
        for each in runs.recordings
    ]
    return replace(runs, recordings=some)


def _keeps_step(name: str, uses: Sequence[Use], changes: Sequence[Array]) -> bool:
    at = [(np.array(list(_jumps(name, use))), change) for use, change in zip(uses, changes, strict=True)]
    met = [(times, change) for times, change in at if len(times)]
    alike = all((np.abs(times[:, None] - change).min(axis=1, initial=np.inf) < NEAR_S).all() for times, change in met)
    return alike and len(met) >= RECORDINGS


def _jumps(name: str, use: Use) -> Iterator[float]:
    """When a channel became another, s: was broken from then on, or counted from another zero."""
    found: ChannelUse = next(one for one in use.channels if one.channel == name)
    yield from (spell.from_s for spell in found.spells)
    yield from (jump.time_s for jump in use.jumps if name in jump.sizes)


def _changes(recording: Recording) -> Array:
    """When the drive started or stopped, s."""
    return np.array([recording.time_s[ticks[0]] for driving, ticks in phases(recording) if driving or ticks[0]])
