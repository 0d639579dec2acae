"""The online filter: one `step(sample)` a tick. Read this first.

    predict   x <- F x + J w            P <- F P F' + Q
    compare   e = y - H x - d           S = H P H' + R
    update    x <- x + K e              K = P H' S^-1

x holds the temperatures of knots and bodies (degC), the unknown zeros of readings (um), the error of the expansion
coefficient (a share) and the span's growth at the start (um). d holds what the inputs add to a reading, the lag of each
thermometer as the open-loop run has it, and what a reading taken before the tick's close had not yet seen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from estimator.errors import SetupError
from estimator.inputs.inputs import Held
from estimator.inputs.start import Start, read_start
from estimator.model import Model
from estimator.network.discretise import Transition
from estimator.network.forcing import Forcing, Ticks
from estimator.record import Array, Recording, Sample, collect
from estimator.rig import Rig
from estimator.state.gate import FIRST_SD_K, GATE, Mute
from estimator.state.open_loop import OpenLoop
from estimator.state.prior import prior
from estimator.state.report import modes, variances
from estimator.state.state import Augmented
from estimator.state.view import View
from estimator.step import Mode, Step, Track

KEPT = 256  # regimes whose matrices are kept, 20 MB or so


@dataclass(frozen=True)
class Comparison:
    """Readings against predictions at one tick, each (m,): innovation, its sd, whether to fuse, why not. rows: H."""

    rows: Array
    predicted: Array
    innovation: Array
    sd: Array
    fuse: Array
    why: tuple[str, ...]


class Filter:
    """The estimate of one rig by one model, a tick at a time.

    mute      decides by time what is not fused: mute(time_s) -> (m,) bool; such channels are still compared
    rejected  (m,) for how many ticks in a row each channel has been beyond the gate
    places    of the table, held where one is late
    x, P      (size,), (size, size) the estimate, once started
    """

    def __init__(self, model: Model, rig: Rig, mute: Mute | None = None) -> None:
        self.model, self.rig = model, rig
        self._mute = mute or (lambda _: np.zeros(len(rig.names), dtype=bool))
        self.rejected = np.zeros(len(rig.names), dtype=int)
        self._transitions: dict[int, Transition] = {}
        self.places = Held()
        self.started = False

    def step(self, sample: Sample) -> Step:
        """Take one tick: start from the first sample with a thermometer in it; then predict, compare, update."""
        if self.started:
            return self._advance(sample, self._ticks(collect("", [sample])), 0)
        start = read_start(sample, self.rig, self._mute(sample.time_s))
        return self._begin(sample, start) if start else self._waiting(sample)

    def run(self, recording: Recording, each: Callable[[int], None] = lambda _: None) -> Track:
        """All ticks of a recording: the same numbers as step by step. `each` hears how many ticks are done."""
        samples = list(recording)
        steps: list[Step] = []
        while not self.started and len(steps) < len(samples):
            steps.append(self.step(samples[len(steps)]))
        while len(steps) < len(samples):
            some = slice(len(steps), len(steps) + KEPT)  # no more regimes than are kept
            ticks = self._ticks(recording.rows(some))
            for k, sample in enumerate(samples[some]):
                steps.append(self._advance(sample, ticks, k))
                each(len(steps))
        x_mm, bodies = (self.view.x_mm, self.view.bodies) if self.started else (np.empty(0), ())
        return Track.of(steps, x_mm, bodies)

    def _ticks(self, chunk: Recording) -> Ticks:
        return self.forcing.ticks(self.forcing.read(chunk))

    def _begin(self, sample: Sample, start: Start) -> Step:
        self.forcing = Forcing(self.model, self.rig, start, keep=KEPT)
        offset = self._ticks(collect("", [sample])).offset[0]
        place, readings = self.forcing.place, self.forcing.readings
        if not np.isfinite(readings.sd[np.isin(self.rig.names, self.rig.thermometers)]).any():
            raise SetupError(f"{self.model.name}: no effect reads a thermometer; add [thermometers] or one with a Read")
        self.view = View(self.rig, place, self.forcing.terms)
        self._state = Augmented(readings, self.rig.expansion_tolerance)
        inputs = {name: value - start.zero_K[name] for name, value in sample.inputs.items()}
        before = prior(start, self.forcing.terms, place, inputs)
        self.x, self.P = self._state.prior(*before)
        R = readings.sd**2 + FIRST_SD_K**2
        compared = self._compare(sample, offset, R)
        self.x, self.P = self._state.first(before, sample.channels - offset, R, compared.fuse)
        self._start_z, self._start_zeros = self.x[: place.size].copy(), self._state.channel_zeros(self.x)
        self.open_loop = OpenLoop(self._start_z, readings, self.rig.tick_s)
        self.started = True
        return self._report(sample, compared, self._open_loop_reading(offset), nis=np.nan)

    @cached_property
    def _kf(self) -> Any:
        """filterpy's filter, from the first estimate on. Imported late: that takes longer than reading a model."""
        from filterpy.kalman import KalmanFilter

        kf = KalmanFilter(dim_x=self._state.size, dim_z=len(self.rig.names))
        kf.x, kf.P = self.x, self.P
        return kf

    def _advance(self, sample: Sample, ticks: Ticks, k: int) -> Step:
        regime, heat = int(ticks.regime[k]), ticks.heat[k]
        self.open_loop.step(self.forcing.transition(regime), heat)
        full = self._transition(regime)
        self._kf.predict(u=heat, B=full.J, F=full.F, Q=full.Q)
        self.x, self.P = self._kf.x, self._kf.P
        readings, lag = self.forcing.readings, self.open_loop.lag
        R = readings.sd**2 + (readings.lag_noise * lag) ** 2
        offset = ticks.offset[k] + lag + self.open_loop.late(sample.ages_s)
        compared = self._compare(sample, offset, R)
        nis = self._update(sample.channels - offset, compared, R)
        return self._report(sample, compared, self._open_loop_reading(ticks.offset[k]), nis)

    def _open_loop_reading(self, offset: Array) -> Array:
        """What the channels would read by the model alone, their zeros as the first sample told them, (m,)."""
        return self.open_loop.reading + offset + self._start_zeros

    def _transition(self, regime: int) -> Transition:
        if regime not in self._transitions:
            if len(self._transitions) >= KEPT:
                self._transitions.clear()
            self._transitions[regime] = self._state.transition(self.forcing.transition(regime), self.rig.tick_s)
        return self._transitions[regime]

    def _compare(self, sample: Sample, offset: Array, R: Array) -> Comparison:
        rows = self._state.rows(self._grown_um())
        predicted = rows @ self.x + offset
        innovation = sample.channels - predicted
        sd = np.sqrt(variances(rows, self.P) + R)
        wild = np.abs(innovation) > GATE.sd * sd
        self.rejected = np.where(wild, self.rejected + 1, 0)
        why = np.full(len(sd), "", dtype=object)
        why[wild & (self.rejected <= GATE.stubborn)] = "implausible jump"
        why[self._mute(sample.time_s)] = "muted"
        why[~np.isfinite(R)] = "no model"
        why[~np.isfinite(sample.channels)] = "not measured"
        return Comparison(rows, predicted, innovation, sd, why == "", tuple(why))

    def _update(self, reading: Array, compared: Comparison, R: Array) -> float:
        """Fuse the channels that were found good; returns NIS = e' S^-1 e, NaN without channels."""
        fuse = compared.fuse
        if not fuse.any():
            return float("nan")
        self._kf.update(reading[fuse], R=np.diag(R[fuse]), H=compared.rows[fuse])
        self._kf.P = (self._kf.P + self._kf.P.T) / 2
        self.x, self.P = self._kf.x, self._kf.P
        return float(self._kf.y @ self._kf.SI @ self._kf.y)

    def _report(self, sample: Sample, compared: Comparison, open_loop: Array, nis: float) -> Step:
        n, x, P = self._state.n, self.x, self.P
        c, profile = self._state.elongation(self._grown_um()), self.view.profile
        um = 1.0 if self.view.has_span else float("nan")  # without a screw nothing grows
        position = self.places.held(np.array([sample.inputs.get("position", np.nan)]))[0]
        table, table_sd = self._table_error(position)
        return Step(
            time_s=sample.time_s,
            mode=Mode(int(modes(compared.fuse, self.rig))),
            elongation_um=float(um * (c @ x)),
            sigma_um=float(um * np.sqrt(max(float(c @ P @ c), 0.0))),
            open_loop_um=um * self._grown_um(),
            profile_C=profile @ x[:n],
            profile_sd_K=np.sqrt(variances(profile, P[:n, :n])),
            bodies_C=x[n - len(self.view.bodies) : n].copy(),
            error_at_table_um=table,
            error_at_table_sd_um=table_sd,
            names=self.rig.names,
            measured=sample.channels,
            predicted=compared.predicted,
            innovation=compared.innovation,
            innovation_sd=compared.sd,
            fused=compared.fuse,
            why=compared.why,
            open_loop=open_loop,
            nis=nis,
            nis_channels=int(compared.fuse.sum()),
            position_mm=float(position),
        )

    def _grown_um(self) -> float:
        """Growth since the start by the model alone, um."""
        return float(self.view.growth @ (self.open_loop.z - self._start_z)) if self.started else 0.0

    def _table_error(self, position_mm: float) -> tuple[float, float]:
        weights = self.view.table_error(position_mm)
        n, x, P = self._state.n, self.x, self.P
        growth = weights @ (x[:n] - self._start_z)
        variance = weights @ P[:n, :n] @ weights + growth**2 * P[-2, -2]
        return float(growth * (1.0 + x[-2])), float(np.sqrt(variance))

    def _waiting(self, sample: Sample) -> Step:
        """A tick before any thermometer has been read: nothing to say but what is missing."""
        m, nan = len(self.rig.names), float("nan")
        gap, empty = np.full(m, nan), np.empty(0)
        return Step(
            sample.time_s, Mode.INIT, nan, nan, nan, empty, empty, empty, nan, nan, self.rig.names, sample.channels,
            gap, gap, gap, np.zeros(m, dtype=bool), ("waiting for a thermometer",) * m, gap, nan, 0,
        )  # fmt: skip
