"""One recording made ready for many models: each becomes a linear system for the compiled engine."""

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from estimator.batch import batch
from estimator.batch.ahead import Ahead
from estimator.batch.judged import Judged, Readings, Unled, judged
from estimator.batch.kernels import carried, followed
from estimator.batch.nominal import Nominal, nominal
from estimator.batch.system import System
from estimator.errors import InputError
from estimator.faults.beside.neighbours import may_be_heat
from estimator.faults.fault import Fault
from estimator.faults.use import Told, Use, use_of
from estimator.model import Model
from estimator.network.forcing import Forcing
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.state.doubt import Doubt
from estimator.state.gate import Mute, unmuted
from estimator.state.run import begin
from estimator.state.state import State

BLOCK_S = 600.0  # the longest: by then a drive is a stop, or nearly done, and what a model misses is another thing
FLOATING = 10.0  # a zero so many times less known than one reading has no meaning of its own


@dataclass(frozen=True)
class Posed:
    """A model on a trial, as the engine takes it.

    heat    (T, n) W into the states;   outside (T, boundaries);   run: the open-loop run
    offset  (T + 1, m) beside the temperatures, from the first sample on
    state   the full state;   system: the linear system of ticks after the first sample
    """

    forcing: Forcing
    state: State
    heat: Array
    outside: Array
    offset: Array
    run: Nominal
    system: System


def with_elongation(system: System, state: State) -> System:
    """The system with one channel more that is never read: the elongation, um."""
    T = len(system.y)
    muted = np.zeros(system.y.shape, dtype=bool) if system.muted is None else system.muted
    return replace(
        system,
        y=np.column_stack([system.y, np.full(T, np.nan)]),
        muted=np.column_stack([muted, np.ones(T, dtype=bool)]),
        H=np.vstack([system.H, state.elongation(state.began_um(system.x0))]),
        spans=np.append(system.spans, 1.0),
        R=np.column_stack([system.R, np.ones(T)]),
    )


class Trial:
    """One recording from its first thermometer reading on: inputs, regimes, and what may be fused, whatever the model.

    Three things are asked once, of the model that the trial is made with, or misfits could not be compared: which
    channels are broken when (unless `gated` is off), how large the lags are by which readings scatter more (`lag`), and
    how long misfits stay alike.

    run           the run as it began;  begin: the first tick after that, with which `rest` begins;  begun: every tick
                  with which it has, for what a run began with may turn out to be no temperatures
    fault         (T, m) of the ticks of `rest`, a Fault each; since_s likewise, and jump, by which zeros became others:
                  from then on that is taken off `rest`
    believed      channels that are heard whatever the judge says of them
    floating      channels whose zero has no meaning: open loop it is the mean of the misfit
    unread_zeros  channels whose unknown zero the first sample did not tell
    block_s       how long a misfit stays alike, and counts as one reading: as long as the rig remembers heat
                  (`Forcing.memory_s`); what is forgotten as exp(-t / tau) has a mean square that scatters as one of
                  so many readings does (Bartlett 1946)
    slopes        how its readings move with parameters at points lately asked for (`hypotheses.slopes`)
    """

    def __init__(
        self,
        model: Model,
        rig: Rig,
        recording: Recording,
        mute: Mute | None = None,
        gated: bool = True,
        since: int = 0,
        believed: Sequence[str] = (),
    ) -> None:
        self.rig, self.recording, self.believed = rig, recording, [rig.index(name) for name in believed]
        self.begun: list[int] = []
        self.slopes: dict[Hashable, Any] = {}
        self._begin(model, mute or unmuted(rig), since)
        if gated:
            self._judge(model, mute or unmuted(rig))

    def _begin(self, model: Model, mute: Mute, since: int) -> None:
        """Begin with the first sample that will do, from tick `since` on."""
        rig, recording = self.rig, self.recording
        run = begin(model, rig, recording, mute, since=since)
        if run is None:
            raise InputError(f"{recording.name}: no thermometer was ever read; nothing to compare with a model")
        if run.tick + 1 == len(recording):
            raise InputError(f"{recording.name}: nothing was recorded after the first thermometer reading")
        self.run, self.begin = run, run.tick + 1
        self.begun.append(run.tick)
        self.rest = recording.rows(slice(self.begin, None))
        self._forcing = Forcing(model, rig, run.start)
        self.drive = self._forcing.read(recording.rows(slice(run.tick, None)))
        readings = self._forcing.readings
        self.muted = np.array([mute(t) for t in self.rest.time_s]) | ~np.isfinite(readings.sd)
        self.floating = np.flatnonzero(readings.zero_sd > FLOATING * readings.sd)
        self.unread_zeros = [i for i in np.flatnonzero(readings.zero_sd) if not run.fuse[i]]
        self.lag = np.zeros_like(self.rest.channels)
        self.lag = self.pose(model).run.lag
        self.block_s = float(np.clip(self._forcing.memory_s, rig.tick_s, BLOCK_S))
        self.fault = np.zeros(self.rest.channels.shape, dtype=np.int8)
        self.since_s, self.jump = np.full(self.fault.shape, np.nan), np.zeros(self.fault.shape)
        self._side = np.zeros(len(rig.names))  # of each channel, the sum by which it is off where it drifts

    def _judge(self, model: Model, mute: Mute) -> None:
        """Leave out what is broken."""
        posed = self.pose(model)
        for part in self.filtered(posed, self.doubt(posed), closely=False):
            if part.judgement.anew:
                self._begin(model, mute, since=self.begin + part.chunk.ticks.stop - 1)
                self._judge(model, mute)
                return
            self.take(part, posed.system)
        self.settle()

    def take(self, part: Judged, system: System) -> None:
        """Note what the judge says of some ticks."""
        judgement, at = part.judgement, part.chunk.ticks
        self.fault[at], self.since_s[at] = judgement.fault, judgement.since_s
        if judgement.jump is not None:
            self.jump[at.stop - 1] = judgement.jump
        off = system.y[at] - part.chunk.predicted
        self._side += np.where(judgement.fault == Fault.DRIFTING, np.nan_to_num(off), 0.0).sum(axis=0)

    def settle(self) -> None:
        """Leave out what all that was taken says is broken, and take off readings what their zeros jumped by.

        What drifts as it would next to heat that the model lacks is not left out: else nobody would find that heat.
        Nor are lengths by which the screw expands otherwise: nobody would find how.
        """
        well = (self.fault == Fault.DRIFTING) & may_be_heat(self._side, self.rig) | (self.fault == Fault.APART)
        well[:, self.believed] = True
        self.fault[well], self.since_s[well] = Fault.NONE, np.nan
        self.jump[:, self.believed] = 0.0
        self.muted |= self.fault != Fault.NONE
        self.rest = replace(self.rest, channels=self.rest.channels - self.jumped)

    @property
    def jumped(self) -> Array:
        """By how much the zeros have become others before each tick, (T, m)."""
        return np.vstack([np.zeros(len(self.rig.names)), np.cumsum(self.jump, axis=0)[:-1]])

    @property
    def use(self) -> Use:
        """What was used of the recording, channel by channel."""
        run, K = self.run, len(self.recording)
        fused = np.isfinite(self.rest.channels) & ~self.muted
        told = Told(
            self.recording.time_s,
            np.isin(np.arange(K), self.begun),
            self.recording.channels,
            np.isfinite(self._forcing.readings.sd),
            self._whole(run.fuse, fused),
            self._whole(run.fault, self.fault),
            self._whole(np.where(run.fault, run.sample.time_s, np.nan), self.since_s),
            np.zeros(self.recording.channels.shape),  # what may drift may be heat that the model lacks: it is sought
            self._whole(np.zeros(len(run.fault)), self.jump),
            self._whole(self.drive.inputs.fault[0], self.drive.inputs.fault[1:]),
            np.zeros(K),  # nor is heat in another place the position's fault as long as effects are sought
        )
        return use_of(self.recording, self.rig, told)

    def _whole(self, first: Array, rest: Array) -> Array:
        """The first tick of the run (m,) and the rest (T, m), after ticks of nothing."""
        return np.vstack([np.zeros((self.run.tick, len(first)), rest.dtype), first[None], rest])

    @property
    def heard(self) -> Recording:
        """The recording without what was refused, and without the time before the run began."""
        refused = self._whole(self.run.fault, self.fault) != Fault.NONE
        refused[: self.run.tick] = True
        channels = self.recording.channels.copy()
        channels[self.begin :] = self.rest.channels
        return replace(self.recording, channels=np.where(refused, np.nan, channels))

    def pose(self, model: Model) -> Posed:
        """The model as a linear system."""
        forcing = self._forcing.with_model(model)
        ticks = forcing.ticks(self.drive)
        readings, state = forcing.readings, State(forcing.readings, self.rig, model.expansion_sd(self.rig))
        x0, P0 = self.run.estimate(readings, forcing.terms, forcing.place, ticks.offset[0])
        F, response = forcing.response(ticks)
        regime, response = ticks.regime[1:], response[1:]
        run = nominal(
            x0[state.temperatures], F, regime, response, readings, readings.growth, self.rest.ages_s, self.rig.tick_s
        )
        system = System(
            y=self.rest.channels - ticks.offset[1:] - run.lag - run.late,
            muted=self.muted,
            regime=regime,
            b=np.pad(response, ((0, 0), (0, state.size - state.n))),
            F=F,
            Q=np.array([state.transition(forcing.transition(r), self.rig.tick_s).Q for r in range(len(F))]),
            H=state.rows(0.0),
            spans=state.spans,
            column=state.expansion,
            grown=run.grown,
            R=readings.sd**2 + (readings.lag_noise * self.lag) ** 2,
            x0=x0,
            P0=P0,
        )
        return Posed(forcing, state, ticks.heat[1:], ticks.outside[1:], ticks.offset, run, system)

    def doubt(self, posed: Posed) -> Doubt:
        """What doubtful parameters make of the run, from its first sample on."""
        return Doubt(replace(self.run, forcing=posed.forcing), (carried, followed))

    def ahead(self, posed: Posed, doubt: Doubt) -> Ahead:
        """How the readings of the open-loop run move with doubtful parameters, in order of time."""
        return Ahead(doubt, posed.system, posed.run, self.drive, (posed.heat, posed.offset, posed.outside))

    def filtered(self, posed: Posed, doubt: Doubt, closely: bool = True) -> Iterator[Judged]:
        """The ticks after the first as the filter leaves them, by the judge that the online filter has.

        `doubt` is carried ahead of the filter; whoever needs it behind it has to do that part after part, `closely`:
        who asks for the judgements alone needs neither gains nor what the filter without lengths is in doubt by.
        """
        alone, ahead = posed.run.lagged + posed.offset[1:], self.ahead(posed, doubt)
        drive = self.drive.rows(slice(1, None))
        readings = Readings(self.rest.time_s, self.rest.channels, alone, self.muted, ahead, drive.astray, drive.driven)
        begun_s = float(self.recording.time_s[self.begun[0]])
        unled = Unled(posed.system, posed.state, doubt, self.rig, closely, lambda: self.ahead(posed, self.doubt(posed)))
        return judged(posed.system, readings, self.run.judge(doubt.known, begun_s), posed.state, unled, closely)

    def loglike(self, model: Model) -> float:
        """Log-likelihood of the readings after the first sample, given that one."""
        return batch.loglike(self.pose(model).system)
