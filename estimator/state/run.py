"""A run begun: what its first sample makes known, whoever carries the estimate on, the filter or its compiled twin."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from estimator.errors import SetupError
from estimator.faults.fault import Fault
from estimator.faults.judge import Judge
from estimator.faults.machine import Known
from estimator.inputs.gate import believable
from estimator.inputs.start import Start, read_start
from estimator.model import Model
from estimator.network.assemble import Readings
from estimator.network.forcing import Forcing
from estimator.network.layout import Layout
from estimator.record import Array, Recording, Sample
from estimator.rig import Rig
from estimator.state.gate import Innovation, Mute, first_faults
from estimator.state.open_loop import OpenLoop
from estimator.state.prior import prior
from estimator.state.state import State
from estimator.state.view import View
from estimator.terms import Term

FIRST_SD_K = 0.3  # the first reading may be a spike too, and has nothing to be checked against


@dataclass(frozen=True)
class Run:
    """A model on a rig from the first sample with a thermometer in it on.

    tick     which of the recording's ticks that is
    forcing  turns inputs into regimes, heat and offsets; it has read the first sample
    offset   (m,) what the channels read beside the temperatures, at the first sample
    first    the first readings against what was known before them
    fault, muted, fuse  (m,) of them: what is too far off, what is muted, and what is used
    x, P     estimate after them, (size,), (size, size)
    """

    tick: int
    start: Start
    sample: Sample
    forcing: Forcing
    state: State
    view: View
    offset: Array
    first: Innovation
    fault: Array
    muted: Array
    fuse: Array
    x: Array
    P: Array

    def judge(self, known: Known, begun_s: float) -> Judge:
        """The judge of the readings after the first, by a model whose parameters are known so well.

        begun_s  when the first run began, where this one has begun again
        """
        return Judge(self.forcing.rig, self.forcing.readings.sd, begun_s, self.fuse, known)

    def grown_um(self, z: Array) -> float:
        """Growth of the span since the start, um, when the temperatures are z (n,)."""
        return float(self.view.growth @ (z - self.x[self.state.temperatures]))

    @property
    def began_um(self) -> float:
        """Growth at the start: 0 but for a rig with a zero_C, which counts from there."""
        return self.state.began_um(self.x)

    @property
    def zero(self) -> Array:
        """Temperatures from which growth counts, (n,) degC: those at the start, or the rig's zero_C everywhere."""
        zero_C, z = self.forcing.rig.zero_C, self.x[self.state.temperatures]
        return z if zero_C is None else np.full_like(z, zero_C)

    def by(self, model: Model) -> "Run":
        """The run by another model of the same states and readings; a SetupError where these are others."""
        forcing = self.forcing.with_model(model)
        pairs = zip(vars(forcing.readings).values(), vars(self.forcing.readings).values(), strict=True)
        if forcing.place.nodes != self.forcing.place.nodes or not all(np.array_equal(a, b) for a, b in pairs):
            raise SetupError("its states or readings are part of the estimate")
        return replace(self, forcing=forcing)

    def open_loop(self) -> OpenLoop:
        """The model alone, from the first estimate on."""
        return OpenLoop(self.x[self.state.temperatures], self.forcing.readings, self.forcing.rig.tick_s)

    def estimate(self, readings: Readings, terms: Sequence[Term], place: Layout, offset: Array) -> tuple[Array, Array]:
        """Estimate after the same first readings by another model's terms; complex where its readings are."""
        state = State(readings, self.forcing.rig, self.forcing.model.expansion_sd(self.forcing.rig))
        before = prior(self.start, terms, place, self.sample.inputs)
        return state.first(before, self.sample.channels - offset, _variance(readings), self.fuse)


def begin(
    model: Model, rig: Rig, recording: Recording, mute: Mute, keep: int | None = None, since: int = 0
) -> Run | None:
    """Begin with the first sample from tick `since` on that has a thermometer which is not muted; None where none has.
    `keep`: of Forcing.

    A model that reads no thermometer is a SetupError.
    """
    begun = _first_start(recording, rig, mute, since)
    if begun is None:
        return None
    tick, start = begun
    sample, forcing = recording.sample(tick), Forcing(model, rig, start, keep=keep)
    sample = replace(sample, inputs=believable(sample.inputs, rig, start))
    readings, place = forcing.readings, forcing.place
    if not np.isfinite(readings.sd[rig.is_thermometer]).any():
        raise SetupError(f"{model.name}: no effect reads a thermometer; add [thermometers] or one with a Read")
    offset = forcing.ticks(forcing.read(recording.rows(slice(tick, tick + 1)))).offset[0]
    mean, cov = prior(start, forcing.terms, place, sample.inputs)
    R = _variance(readings)
    sd = np.sqrt(variances(readings.rows, cov) + readings.zero_sd**2 + R)
    predicted = readings.rows @ mean + offset
    first, muted = Innovation(predicted, sample.channels - predicted, sd), mute(sample.time_s)
    state, fault = State(readings, rig, model.expansion_sd(rig)), first_faults(first)
    fuse = first.usable & ~muted & (fault == Fault.NONE)
    x, P = state.first((mean, cov), sample.channels - offset, R, fuse)
    view = View(rig, place, forcing.terms)
    return Run(tick, start, sample, forcing, state, view, offset, first, fault, muted, fuse, x, P)


def _first_start(recording: Recording, rig: Rig, mute: Mute, since: int) -> tuple[int, Start] | None:
    """The first tick with a thermometer that is not muted, and the run's start by it; None where there is none."""
    for k in range(since, len(recording)):
        sample = recording.sample(k)
        if start := read_start(sample, rig, mute(sample.time_s)):
            return k, start
    return None


def variances(rows: Array, P: Array) -> Array:
    """Diagonal of rows P rows', (..., m) of P (..., n, n), never below 0."""
    return np.asarray(np.maximum(np.vecdot(rows @ P, rows), 0.0))


def _variance(readings: Readings) -> Array:
    """R of the first readings."""
    return np.asarray(readings.sd**2 + FIRST_SD_K**2)
