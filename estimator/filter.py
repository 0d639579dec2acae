"""The online filter: one `step(sample)` a tick.

    predict   x <- F x + J w            P <- F P F' + Q
    compare   e = y - H x - d           S = H P H' + R
    update    x <- x + K e              K = P H' S^-1

x holds the temperatures of knots and bodies, the unknown zeros of readings, the error of the expansion coefficient and
the span's growth at the start (state/state.py). d holds what the inputs add to a reading, the lag of each thermometer
as the open-loop run has it, and what a reading taken before the tick's close had not yet seen. batch/ does the same for
whole recordings.
"""

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from estimator.faults.fault import Fault, Judgement, Led, Seen
from estimator.model import Model
from estimator.network.discretise import Transition
from estimator.network.forcing import Drive
from estimator.record import Array, Recording, Sample, collect
from estimator.rig import Rig
from estimator.state.doubt import Doubt
from estimator.state.gate import Innovation, Mute, unmuted
from estimator.state.moves import Course, Moves
from estimator.state.report import Estimates, Reporter
from estimator.state.run import Run, begin, variances
from estimator.step import Step, TableErrors, Track
from estimator.work import one_thread

KEPT = 256  # regimes whose matrices are kept, 20 MB or so


class Filter:
    """The estimate of one rig by one model, a tick at a time.

    mute    decides by time what is not fused: mute(time_s) -> (m,) bool; such channels are still compared
    run     what the first sample with a thermometer in it made known; None before
    fusion  the estimate, from then on
    """

    def __init__(self, model: Model, rig: Rig, mute: Mute | None = None) -> None:
        self.model, self.rig, self.mute = model, rig, mute or unmuted(rig)
        self.run: Run | None = None
        self._begun_s: float | None = None
        self._transitions: dict[int, Transition] = {}
        self._read: tuple[Sample, Drive] | None = None  # a sample that an effect has failed in

    def __repr__(self) -> str:
        since = "running" if self.run else "before its first thermometer"
        return f"Filter: {self.model.name} on {self.rig.name}, {since}"

    @one_thread
    def step(self, sample: Sample) -> Step:
        """Take one tick: begin with the first sample with a thermometer in it; then predict, compare, update."""
        rows = collect("", [sample])
        if self.run is None:
            return self._begin(rows)
        if self._read is None or self._read[0] is not sample:
            self._read = sample, self.run.forcing.read(rows)
        step = self._advance(self.run, sample, rows, self._read[1])
        self._read = None
        return step

    def leave_out(self, effect: str) -> None:
        """Go on from the same estimate by the model without an effect, from the tick on that the effect failed in.

        Where states or readings need the effect that cannot be: a SetupError, and nothing has changed.
        """
        model = self.model - effect
        if self.run is not None:
            self.run = self.run.by(model)
            self._doubt: Doubt = self._doubt.by(self.run)
            self._unled.by(self.run)
            self._judge.by_another_model(self._doubt.known)
            self._transitions.clear()
        self.model = model

    def table_errors(self, at_mm: Array) -> TableErrors:
        """The error at the table after the latest tick, were it at places (p,) mm."""
        return self._reporter.table_errors(at_mm, self._latest) if self.run else TableErrors.waiting(at_mm, 1)

    def _begin(self, rows: Recording) -> Step:
        run = self.run = begin(self.model, self.rig, rows, self.mute, KEPT)
        if run is None:
            return Track.waiting(self.rig.names, rows).step(0, ("waiting for a thermometer",) * len(self.rig.names))
        doubt = Doubt(run)
        self._begun_s = run.sample.time_s if self._begun_s is None else self._begun_s
        self.fusion, self._judge = Fusion(run.x, run.P), run.judge(doubt.known, self._begun_s)
        self._unled = Unled(run, doubt.beside())
        self._open_loop, self._doubt, self._reporter = run.open_loop(), doubt, Reporter(run)
        self._transitions.clear()
        self._latest = self._reporter.begun
        return self._reporter.first(rows).step(0, run.first.why(run.fault, run.muted))

    def _advance(self, run: Run, sample: Sample, rows: Recording, drive: Drive) -> Step:
        ticks = run.forcing.ticks(drive)
        alone, offset, muted = self._open_loop, ticks.offset[0], self.mute(sample.time_s)
        before = alone.now
        self._predict(run, int(ticks.regime[0]), ticks.heat[0])
        fusion = self.fusion
        R = run.forcing.readings.sd**2 + (run.forcing.readings.lag_noise * alone.lag) ** 2
        grown_um = run.grown_um(alone.z)
        H, d = run.state.rows(grown_um), offset + alone.lag + alone.late(sample.ages_s)
        predicted, sd = H @ fusion.x + d, np.sqrt(variances(H, fusion.P) + R)
        compared = Innovation(predicted, sample.channels - predicted, sd)
        moves = self._doubt.ahead(drive, ticks, self._course(sample, before, grown_um))
        judged = self._judge.judge(
            Seen(
                time_s=rows.time_s,
                reading=rows.channels,
                value=compared.value[None],
                sd=sd[None],
                alone=(alone.reading + offset)[None],
                muted=muted[None],
                doubt=moves.readings,
                led=self._unled.led,
                astray=drive.astray,
                driven=drive.driven,
            )
        )
        if judged.anew:
            return self._begin(rows)
        fault = judged.fault[0]
        fuse = compared.usable & ~muted & (fault == Fault.NONE)
        nis, gain = fusion.update(sample.channels - d, fuse, H, R)
        doubt = self._doubt.behind(moves, gain[None], judged.off_share)
        fusion.x, fusion.P = run.state.judged(fusion.x, fusion.P, judged)
        self._unled.update(sample.channels - d, fuse, H, R, moves, judged)
        if judged.apart:
            fusion.x, fusion.P = self._unled.fusion.x, self._unled.fusion.P
            self._doubt.become(self._unled.doubt)
        self._unled.compare(fusion.x, grown_um)
        estimates = Estimates.of_tick(
            x=fusion.x,
            P=fusion.P,
            predicted=predicted,
            sd=sd,
            fused=fuse,
            nis=nis,
            alone=alone.reading + offset,
            grown_um=grown_um,
            fault=fault,
            since_s=judged.since_s[0],
            may_drift_K=judged.may_drift_K[0],
            lacks_K=judged.lacks_K[0],
            departs_K=judged.departs_K[0],
            unsure_um=0.0,
            off_share=judged.off_share[0],
            shift_mm=judged.shift_mm[0],
            jump=np.zeros(len(fuse)) if judged.jump is None else judged.jump,
            input_fault=run.forcing.input_fault,
            doubt=doubt.states[0],
            doubt_um=doubt.elongation[0],
        )
        led_var = self._doubt.known.elongation_var(self._unled.led, judged.off_share)
        self._latest = estimates.suspecting(run.state, self._unled.fusion.x[None], led_var)
        return self._reporter.track(rows, self._latest).step(0, compared.why(fault, muted))

    def _course(self, sample: Sample, before: tuple[Array, Array, Array], grown_um: float) -> Course:
        """The open-loop run over the tick that has just been predicted."""
        late_share = np.clip(sample.ages_s / self.rig.tick_s, 0.0, 1.0)[None]
        z, spot, lagged = (np.stack(pair) for pair in zip(before, self._open_loop.now, strict=True))
        return Course(z, spot, lagged, np.array([grown_um]), late_share)

    def _predict(self, run: Run, regime: int, heat: Array) -> None:
        self._open_loop.step(run.forcing.transition(regime), heat)
        if regime not in self._transitions:
            if len(self._transitions) >= KEPT:
                self._transitions.clear()
            self._transitions[regime] = run.state.transition(run.forcing.transition(regime), self.rig.tick_s)
        move = self._transitions[regime]
        self.fusion.predict(move, heat)
        self._unled.fusion.predict(move, heat)


class Fusion:
    """An estimate x (size,), P (size, size), carried by filterpy's filter."""

    def __init__(self, x: Array, P: Array) -> None:
        self.x, self.P = x, P

    def predict(self, move: Transition, heat: Array) -> None:
        """Over one tick."""
        kf = self._filterpy
        kf.predict(u=heat, B=move.J, F=move.F, Q=move.Q)
        self.x, self.P = kf.x, kf.P

    def update(self, reading: Array, fuse: Array, H: Array, R: Array) -> tuple[float, Array]:
        """Fuse the channels that were found good; returns NIS = e' S^-1 e, NaN without channels, and K (size, m)."""
        gain = np.zeros(H.T.shape)
        if not fuse.any():
            return float("nan"), gain
        kf = self._filterpy
        kf.update(reading[fuse], R=np.diag(R[fuse]), H=H[fuse])
        kf.P = (kf.P + kf.P.T) / 2
        self.x, self.P, gain[:, fuse] = kf.x, kf.P, kf.K
        return float(kf.y @ kf.SI @ kf.y), gain

    @property
    def _filterpy(self) -> Any:
        """filterpy's filter at this estimate."""
        self._made.x, self._made.P = self.x, self.P
        return self._made

    @cached_property
    def _made(self) -> Any:
        """Made with the second tick. Imported late: that takes longer than reading a model."""
        from filterpy.kalman import KalmanFilter

        return KalmanFilter(dim_x=len(self.x), dim_z=1)


class Unled:
    """The estimate that hears no length, beside the one that hears all that is well.

    led  how far the other one has been led, as of the last tick
    """

    def __init__(self, run: Run, doubt: Doubt) -> None:
        self.fusion, self.doubt, self.led = Fusion(run.x, run.P), doubt, Led.nowhere(1, len(doubt.known.whole))
        rig = run.forcing.rig
        self._state, self._heat, self._tick_s = run.state, rig.is_thermometer, rig.tick_s

    def by(self, run: Run) -> None:
        """Go on by another model of the run."""
        self.doubt = self.doubt.by(run)
        self.led = replace(self.led, doubt=np.zeros((1, len(self.doubt.known.whole))))

    def update(self, reading: Array, fuse: Array, H: Array, R: Array, moves: Moves, judged: Judgement) -> None:
        """Fuse the thermometers among the channels that were found good."""
        nis, gain = self.fusion.update(reading, fuse & self._heat, H, R)
        growth = self.doubt.slopes(moves, gain[None])[1]
        ratio = np.array([nis / max(1, (fuse & self._heat).sum())])
        self.led = Led(self.led.um, self.led.var, growth, *self.led.worsened(ratio, self._tick_s))
        self.fusion.x, self.fusion.P = self._state.judged(self.fusion.x, self.fusion.P, judged)

    def compare(self, x: Array, grown_um: float) -> None:
        """With the estimate of the other one."""
        um, var = self._state.led(np.array([grown_um]), x[None], (self.fusion.x[None], self.fusion.P[None]))
        self.led = replace(self.led, um=um, var=var)
