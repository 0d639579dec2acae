"""What the inputs do to the model, tick by tick: regime, heat and reading offsets.

Works on any number of ticks at once and remembers what it must between calls, so that a recording in one piece and a
bus tick by tick give the same numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimator import assemble
from estimator.discretise import Transition, transition
from estimator.inputs import Drive, InputReader, Inputs
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.regime import Regimes
from estimator.rig import Rig
from estimator.start import Start
from estimator.structure import checked_terms


@dataclass(frozen=True)
class Ticks:
    """K ticks made ready for the filter.

    regime  (K,)    which transition
    heat    (K, n)  W into the states: sources and boundaries
    offset  (K, m)  what the channels read beside the temperatures
    """

    regime: Array
    heat: Array
    offset: Array


class Forcing:
    """Turns inputs into regimes, heat and offsets for one model on one rig, from one start.

    `reduced=False` keeps every cell as a state: exact, slow, to check the reduced mesh with.
    """

    def __init__(self, model: Model, rig: Rig, start: Start, reduced: bool = True) -> None:
        self.model, self.rig, self.start = model, rig, start
        self._reader = InputReader(rig, start)
        self._regimes = Regimes(rig.tick_s)
        self._transitions: list[Transition] = []
        self._inflow: list[Array] = []
        self.terms = checked_terms(model, self._reader.nothing(), rig)
        self.place = assemble.layout(self.terms, rig, reduced)
        self.readings = assemble.readings(self.terms, rig, self.place)

    def with_model(self, model: Model) -> Forcing:
        """The same inputs and regimes under another model of the same structure."""
        other = Forcing(model, self.rig, self.start)
        other._regimes = self._regimes
        return other

    def transition(self, regime: int) -> Transition:
        """Transition of a regime."""
        return self._transitions[regime]

    def read(self, chunk: Recording) -> Drive:
        """Inputs and regimes of a chunk, whatever the model; call in order of time."""
        u = self._reader.read(chunk)
        pairs = zip(u.omega[:, 0], u.coverage, strict=True)
        return Drive(u, np.array([self._regimes.index(float(omega), coverage) for omega, coverage in pairs]))

    def ticks(self, drive: Drive) -> Ticks:
        """What the model makes of these inputs."""
        self._discretise()
        u, regime = drive.inputs, drive.regime
        terms = list(self.model.terms(u, self.rig))
        heat = assemble.heat(terms, self.place, len(u))
        if self.place.boundaries:
            outside = np.hstack([u[name] for name in self.place.boundaries])
            for r in np.unique(regime):
                heat[regime == r] += outside[regime == r] @ self._inflow[r].T
        return Ticks(regime, heat, assemble.offsets(terms, self.rig, len(u)))

    def _discretise(self) -> None:
        """Assemble and discretise the regimes met since the last call."""
        new = range(len(self._transitions), len(self._regimes.omega))
        if not new:
            return
        omega = np.array([[self._regimes.omega[r]] for r in new])
        coverage = np.array([self._regimes.coverage[r] for r in new])
        none = {name: np.zeros((len(new), 1)) for name in self.rig.inputs}
        network = assemble.network(self.model, self.rig, self.place, Inputs(omega, coverage, none, none))
        for i in range(len(new)):
            self._transitions.append(transition(network, i, self.rig.tick_s))
            self._inflow.append(network.inflow[i])
