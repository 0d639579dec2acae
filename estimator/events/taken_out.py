"""A recording as it would be had an event not been: its readings less what the event made of them.

    z[k + 1] = F z[k] + s b[k]  from the onset on,      y - H z

with b what 1 W, or once more a part of the model, adds to the states, and s the event's size.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estimator.batch.kernels import coast
from estimator.batch.trial import Trial
from estimator.events.carriers import Carrier, carriers
from estimator.events.event import DRIVING, LOOSE, PART, Event
from estimator.inputs.phase import turns
from estimator.model import Model
from estimator.record import Array, Recording


def taken_out(recording: Recording, trial: Trial, model: Model, events: Sequence[Event]) -> Recording:
    """The recording without events, which were found on a trial of it with this model."""
    at_s = trial.rest.time_s
    made = sum((response(trial, model, event) for event in events), np.zeros(trial.rest.channels.shape))
    whole = np.stack([np.interp(recording.time_s, at_s, column, left=0.0) for column in made.T], axis=1)
    inputs = dict(recording.inputs)
    if "displacement_direct" in inputs and "displacement" in trial.rig.names:
        inputs["displacement_direct"] = inputs["displacement_direct"] - whole[:, trial.rig.index("displacement")]
    return replace(recording, channels=recording.channels - whole, inputs=inputs)


def response(trial: Trial, model: Model, event: Event) -> Array:
    """What an event makes of each reading, (T, m); lags of seconds do not count."""
    lasts = trial.rest.time_s >= event.since_s
    if event.until_s is not None:
        lasts &= trial.rest.time_s < event.until_s
    posed = trial.pose(model)
    if event.channel is not None:
        own = np.arange(len(trial.rig.names)) == trial.rig.index(event.channel)
        rise = posed.run.lagged - posed.run.spot[:1]
        made = (event.share or 0.0) * rise if event.kind == LOOSE else event.offset or 0.0
        return np.asarray(np.outer(lasts, own) * made)
    if event.kind == DRIVING:
        lasts &= turns(trial.rest.omega)
    (carrier,) = (each for each in carriers(trial, posed, model) if _carries(each, event))
    size = event.share if event.kind == PART else event.heat_W
    push = carrier.push * (lasts * (size or 0.0))[:, None]
    z = coast(posed.system.F, posed.system.regime, push, np.zeros(push.shape[1]))
    return np.asarray(z @ posed.run.readings.rows.T)


def _carries(carrier: Carrier, event: Event) -> bool:
    if carrier.zone is None or carrier.zone.node is not None:
        return carrier.name == event.name
    return (carrier.zone.from_mm, carrier.zone.to_mm) == (event.from_mm, event.to_mm)
