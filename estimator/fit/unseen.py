"""How well the estimate knows the places between its thermometers: every third one on the screw is never seen.

The heat that no effect describes, place by place, is what a filter trades against the unknown zeros of thermometers:
with too little of it, what a model lacks at one place becomes a zero that has walked, and the estimate stays with the
model. What was seen cannot tell the two apart. A thermometer that was not seen can: it is predicted from its neighbours
and the model, with an error as large as the filter says where that noise is right,

    e = y - predicted,   sd^2 = P + scatter^2 + (gain_sd rise)^2 + lag^2

once a minute, ten of which weigh as one: errors last. It is scored as blind minutes are (`accuracy.blind`).
"""

from dataclasses import replace

import numpy as np

from estimator.accuracy.blind import BLIND_S, LOOK_S, Scored
from estimator.batch import batch
from estimator.batch.trial import Posed, Trial
from estimator.model import Model
from estimator.record import Array
from estimator.terms import SCREW, Read, Spot

EVERY = 3  # of so many thermometers in a row one is not seen: both its neighbours are
FEWEST = 5  # thermometers of a screw, that two next to each other are left on each side of most


def unseen(trial: Trial, model: Model) -> Scored:
    """Thermometers on the screw, a third of them unseen from the first sample on, in three passes."""
    posed = trial.pose(model)
    places, every = on_screw(posed), max(1, round(LOOK_S / trial.rig.tick_s))
    found = np.empty((0, 3))
    for first in range(EVERY if len(places) >= FEWEST else 0):
        hidden = places[first::EVERY]
        muted = trial.muted.copy()
        muted[:, hidden] = True
        told = batch.compared(replace(posed.system, muted=muted), muted & ~trial.muted)
        off, sd = posed.system.y - told.predicted, np.hypot(told.sd, _own_gain(posed))
        for channel in hidden:
            read = np.flatnonzero(np.isfinite(off[:, channel]) & ~trial.muted[:, channel])[every - 1 :: every]
            scored = off[read, channel], sd[read, channel], np.full(len(read), channel)
            found = np.vstack([found, np.column_stack(scored)])
    error, sd, channels = found.T
    weight = LOOK_S / BLIND_S / max(trial.rig.is_thermometer.sum(), 1)
    return Scored(error, sd, channels.astype(int), np.full(len(found), weight))


def on_screw(posed: Posed) -> list[int]:
    """Channels that read the screw's temperature at a place, from one end to the other."""
    rig, at = posed.forcing.rig, {}
    for term in posed.forcing.terms:
        if isinstance(term, Read) and isinstance(spot := term.weights.get(SCREW), Spot):
            at[rig.index(term.channel)] = spot.at_mm
    return sorted(at, key=lambda channel: at[channel])


def _own_gain(posed: Posed) -> Array:
    """What each thermometer's own gain may make of it, (T, m) K: no error of the estimate."""
    readings, run = posed.forcing.readings, posed.run
    return np.asarray(readings.gain_sd * (run.lagged - readings.rows @ run.z[0]))
