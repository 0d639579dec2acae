"""How everything that a model's terms yield on a trial moves with one parameter."""

from dataclasses import dataclass

import numpy as np

from estimator.batch.trial import Posed, Trial
from estimator.model import Model
from estimator.network.assemble import Network
from estimator.record import Array
from estimator.state.tangent import Moved, ReadingsTangent


@dataclass(frozen=True)
class Tangent:
    """Derivatives along one parameter: heat (T, n), outside (T, boundaries), offset (T, m) after the first sample."""

    network: Network
    heat: Array
    outside: Array
    offset: Array
    readings: ReadingsTangent | None

    @property
    def moves_noise(self) -> bool:
        """Whether the parameter moves a scatter or what is not known at the start."""
        parts = [self.network.noise]
        if self.readings is not None:
            r = self.readings
            parts += [r.variance, r.lag_variance, r.walk, r.P0]
        return any(np.any(part != 0) for part in parts)

    @property
    def moves_states(self) -> bool:
        """Whether the parameter moves the temperatures after the start."""
        parts = [self.network.mass, self.network.conductance, self.network.inflow, self.heat, self.outside]
        return any(np.any(part != 0) for part in parts)

    @property
    def moves_mean(self) -> bool:
        """Whether the parameter moves what the model predicts."""
        parts = [self.offset]
        if self.readings is not None:
            r = self.readings
            parts += [r.rows, r.growth, r.spans, r.keep, r.ramp]
        return self.moves_states or any(np.any(part != 0) for part in parts)


def tangent(trial: Trial, posed: Posed, model: Model, path: str) -> Tangent:
    """Derivatives along parameter "effect.param" of a model, which differs from the one posed in values at most."""
    moved = Moved(posed.forcing, model, path)
    ticks = moved.ticks(trial.drive)
    readings = moved.readings(trial.run, posed.offset[0], ticks.offset[0])
    return Tangent(moved.network(), ticks.heat[1:], ticks.outside[1:], ticks.offset[1:], readings)
