"""The filter over a whole recording by the compiled engine: the same numbers as `Filter`, a tick at a time.

And, after the fact, the smoother: the best estimate of each tick, from the readings before and after it.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from estimator.batch import batch
from estimator.batch.judged import Judged
from estimator.batch.system import System
from estimator.batch.trial import Posed, Trial, with_elongation
from estimator.faults.fault import Fault
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.state.doubt import Doubt
from estimator.state.gate import Mute, unmuted
from estimator.state.report import Estimates, Reporter
from estimator.state.run import Run, begin
from estimator.state.state import State
from estimator.step import TableErrors, Track

ROWS = 2048  # ticks whose profiles are worked out at a time


@dataclass(frozen=True)
class SmoothedElongation:
    """Elongation from all readings of a recording, (K,) um, and its standard deviation; NaN before the start."""

    elongation_um: Array
    sigma_um: Array


def replay(
    model: Model, rig: Rig, recording: Recording, mute: Mute | None = None, each: Callable[[int], None] = lambda _: None
) -> Track:
    """All ticks of a recording. `each` hears how many ticks are done."""
    return Replay(model, rig, recording, mute, each).track


class Replay:
    """A recording as the filter leaves it, the `track`, and what the smoother makes of it.

    table  the error at the table, were it at `table_mm`

    run    as it began; None where no thermometer was ever read
    trial  the ticks after its first, without what was refused; None where there are none
    Where a run began with what were no temperatures, it begins again; the smoother has the last of the runs.
    """

    def __init__(
        self, model: Model, rig: Rig, recording: Recording, mute: Mute | None, each: Callable[[int], None],
        table_mm: Sequence[float] = (),
    ) -> None:  # fmt: skip
        self._model, self._rig, self._recording, self._mute = model, rig, recording, mute or unmuted(rig)
        self._solved: tuple[System, State] | None = None
        self._doubt_um2 = list[Array]()
        self.run: Run | None = None
        self.trial: Trial | None = None
        self._at_mm = np.array(table_mm, dtype=float)
        self._table: list[TableErrors] = []
        self.track = Track.joined(self._parts(each), len(recording))
        self.table = TableErrors.joined(self._table)

    def _parts(self, each: Callable[[int], None]) -> Iterator[Track]:
        """The recording, some ticks at a time."""
        at, recording = 0, self._recording
        while at < len(recording):
            run, self.trial, self._solved = begin(self._model, self._rig, recording, self._mute, since=at), None, None
            first = len(recording) if run is None else run.tick
            yield Track.waiting(self._rig.names, recording.rows(slice(at, first)))
            self._table.append(TableErrors.waiting(self._at_mm, first - at))
            at = first + 1
            if run is not None:
                self.run, reporter = run, Reporter(run)
                yield reporter.first(recording.rows(slice(first, at)))
                self._table.append(reporter.table_errors(self._at_mm, reporter.begun))
                for part in self._rest(reporter, first):
                    yield part
                    each(at := at + len(part))

    def _rest(self, reporter: Reporter, at: int) -> Iterator[Track]:
        """The ticks after the first of a run, up to one with which it begins anew."""
        if at + 1 == len(self._recording):
            return
        trial = Trial(self._model, self._rig, self._recording, self._mute, gated=False, since=at)
        posed = trial.pose(self._model)
        self.trial, self._solved, self._doubt_um2 = trial, (posed.system, posed.state), []
        doubt = trial.doubt(posed)
        for part in trial.filtered(posed, doubt):
            trial.take(part, posed.system)
            for rows, estimates in _estimates(trial, posed, part, doubt):
                self._doubt_um2.append((estimates.doubt_um**2).sum(axis=1))
                track = reporter.track(trial.rest.rows(rows), estimates)
                self._table.append(reporter.table_errors(self._at_mm, estimates))
                yield track
        trial.settle()

    def smoothed(self) -> SmoothedElongation:
        """The elongation after the fact, from readings that the filter fused, and of which nothing may have drifted.

        Nothing for less than two ticks.
        """
        um, sigma = np.full((2, len(self.track)), np.nan)
        if self._solved is not None and self.trial is not None:
            system, state = self._solved
            T = len(system.y)
            parted = (self.track.fault[-T:] == Fault.APART).any(axis=0)  # nobody knows since when
            drifted = np.maximum.accumulate(self.track.fault[-T:] == Fault.DRIFTING)  # and its zero may be any since
            heard = self.track.fused[-T:] & (self.track.may_drift_K[-T:] == 0) & ~drifted & ~parted
            system = replace(system, y=system.y - self.trial.jumped, muted=~heard)
            elongation = len(system.H)  # the channel that is never read
            reading, var = batch.smoothed_reading(with_elongation(system, state), elongation)
            grows = np.isfinite(self.track.elongation_um[-T:])
            um[-T:] = np.where(grows, reading, np.nan)
            doubt_um2 = np.concatenate(self._doubt_um2)  # no reading makes a parameter better known, earlier or later
            sigma[-T:] = np.where(grows, np.sqrt(np.maximum(var, 0.0) + doubt_um2), np.nan)
            um[-T - 1], sigma[-T - 1] = self.track.elongation_um[-T - 1], self.track.sigma_um[-T - 1]
        return SmoothedElongation(um, sigma)


def _estimates(trial: Trial, posed: Posed, part: Judged, doubt: Doubt) -> Iterator[tuple[slice, Estimates]]:
    """Ticks as far as the run goes on, some at a time."""
    run, offset, chunk, judgement = posed.run, posed.offset[1:], part.chunk, part.judgement
    last = chunk.ticks.stop - judgement.anew
    jump = np.zeros(judgement.fault.shape)
    if judgement.jump is not None:
        jump[-1] = judgement.jump
    for k in range(0, last - chunk.ticks.start, ROWS):
        at = slice(chunk.ticks.start + k, min(chunk.ticks.start + k + ROWS, last))
        some = slice(k, k + at.stop - at.start)
        doubtful = doubt.behind(part.moves.rows(some), chunk.gain[some], judgement.off_share[some])
        x, P = chunk.x[some].copy(), chunk.P[some].copy()
        if at.stop == chunk.ticks.stop:
            x[-1], P[-1] = part.after
        estimates = Estimates(
            x=x,
            P=P,
            predicted=chunk.predicted[some] + offset[at] + run.lag[at] + run.late[at],
            sd=chunk.sd[some],
            fused=chunk.fused[some],
            nis=chunk.nis[some],
            alone=run.lagged[at] + offset[at],
            grown_um=run.grown[at],
            fault=judgement.fault[some],
            since_s=judgement.since_s[some],
            may_drift_K=judgement.may_drift_K[some],
            lacks_K=judgement.lacks_K[some],
            departs_K=judgement.departs_K[some],
            unsure_um=np.zeros(at.stop - at.start),
            off_share=judgement.off_share[some],
            shift_mm=judgement.shift_mm[some],
            jump=jump[some],
            input_fault=trial.drive.inputs.fault[1:][at],
            doubt=doubtful.states,
            doubt_um=doubtful.elongation,
        )
        led_var = doubt.known.elongation_var(part.led[some], judgement.off_share[some])
        yield at, estimates.suspecting(posed.state, part.unled[some], led_var)
    if judgement.apart:
        doubt.become(part.doubt)
