"""The estimate in the terms of a person, of one tick or of thousands: live and after the fact by the same lines."""

from dataclasses import dataclass, replace

import numpy as np

from estimator.inputs.inputs import Held
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.state.run import Run, variances
from estimator.state.state import State
from estimator.state.view import BedGrowth, Mounting
from estimator.step import Mode, TableErrors, Track

LENGTHS_LIE = 0.3  # of how far they lead from what thermometers alone say, and of how much better they make it known
HIDDEN = 0.3  # of heat at one thermometer that the next ones show too little of: they are 50 to 150 mm away


@dataclass(frozen=True)
class Estimates:
    """K ticks as a filter leaves them.

    x, P       (K, size), (K, size, size) after the tick
    predicted  (K, m) readings as expected before any of the tick was used; sd (K, m) of a reading around it
    fused      (K, m) bool;   nis (K,)
    alone      (K, m) readings by the model alone, from the first estimate of temperatures on
    grown_um   (K,)   growth of the span since the start by the model alone
    fault, since_s  (K, m) of the channels, a Fault each and since when;   jump (K, m) of their zeros
    may_drift_K     (K, m) by how much those that are fused may have drifted, 0: not suspected
    lacks_K         (K, m) by how much they depart from the others by heat that the model lacks, 0: they do not
    departs_K       (K, m) by how much others do, which models lack in detail, or which have begun to drift
    unsure_um       (K,) what the elongation is off by if what may drift does, and by such heat
    off_share  (K,) by which share of their values the model's parameters must be off;   shift_mm (K,) the position
    input_fault     (K, p) of the inputs
    doubt      (K, size, q) what the states are off by, and doubt_um (K, q) the elongation, per standard normal error of
               the model's parameters
    """

    x: Array
    P: Array
    predicted: Array
    sd: Array
    fused: Array
    nis: Array
    alone: Array
    grown_um: Array
    fault: Array
    since_s: Array
    may_drift_K: Array
    lacks_K: Array
    departs_K: Array
    unsure_um: Array
    off_share: Array
    shift_mm: Array
    jump: Array
    input_fault: Array
    doubt: Array
    doubt_um: Array

    @classmethod
    def of_tick(cls, **tick: Array | float) -> "Estimates":
        """One tick, its fields without the leading axis, as the online filter has it."""
        return cls(**{name: np.asarray(value)[None] for name, value in tick.items()})

    def suspecting(self, state: State, unled: Array, unled_var: Array) -> "Estimates":
        """The same, in doubt also by what it would be off by if what may drift did, or if it were heat; by other heat
        that the model lacks, of which thermometers far apart show too little; by what departs; and if lengths lied.

        unled  (K, size) the estimates by thermometers alone;   unled_var (K,) um^2, of their elongation
        """
        var = state.led(self.grown_um, self.x, (self.x, self.P))[1] + (self.doubt_um**2).sum(axis=1)
        better_um = np.sqrt(np.maximum(unled_var - var, 0.0))
        lies = LENGTHS_LIE * (self.x - unled)[:, :, None]
        unknown = [state.astray(self.P, K) for K in (self.may_drift_K, HIDDEN * self.lacks_K, self.departs_K)]
        astray = np.concatenate([*unknown, lies], axis=2)
        astray_um = np.einsum("ks,ksq->kq", state.elongation(self.grown_um), astray)
        unsure_um = np.sqrt((astray_um[:, :-1] ** 2).sum(axis=1))
        doubt = np.concatenate([self.doubt, astray], axis=2)
        doubt_um = np.hstack([self.doubt_um, astray_um, LENGTHS_LIE * better_um[:, None]])
        return replace(self, doubt=doubt, doubt_um=doubt_um, unsure_um=unsure_um)


class Reporter:
    """Turns estimates of one run into tracks, in order of time: a position that is late is the one of before."""

    def __init__(self, run: Run) -> None:
        self._rig, self._view, self._state, self._run = run.forcing.rig, run.view, run.state, run
        self._zeros = run.state.channel_zeros(run.x)
        self._position, self._mounting, self._bed = Held(), Mounting(run.view, run.forcing), BedGrowth(run.forcing.rig)

    @property
    def begun(self) -> Estimates:
        """The tick with which the run began."""
        run, first = self._run, self._run.first
        alone = run.forcing.readings.rows @ run.x[run.state.temperatures] + run.offset
        judged = np.where(run.fault, run.sample.time_s, np.nan)
        return Estimates.of_tick(
            x=run.x,
            P=run.P,
            predicted=first.predicted,
            sd=first.sd,
            fused=run.fuse,
            nis=np.nan,
            alone=alone,
            grown_um=0.0,
            fault=run.fault,
            since_s=judged,
            may_drift_K=np.zeros(len(judged)),
            lacks_K=np.zeros(len(judged)),
            departs_K=np.zeros(len(judged)),
            unsure_um=0.0,
            off_share=0.0,
            shift_mm=0.0,
            jump=np.zeros(len(judged)),
            input_fault=run.forcing.input_fault,
            doubt=np.zeros((len(run.x), 0)),
            doubt_um=np.zeros(0),
        )

    def first(self, rows: Recording) -> Track:
        """What was measured at that tick, and what is estimated of it."""
        return replace(self.track(rows, self.begun), begins=np.ones(1, dtype=bool))

    def track(self, rows: Recording, estimates: Estimates) -> Track:
        """The next ticks: what was measured, and what is estimated of it."""
        view, state, x, P, fused = self._view, self._state, estimates.x, estimates.P, estimates.fused
        um = 1.0 if view.has_span else np.nan  # without a screw nothing grows
        z, P_z = self._temperatures(estimates)
        grown_um = self._run.began_um + estimates.grown_um
        elongation = state.elongation(grown_um)
        self._bed.read(rows, estimates.input_fault)
        position = self._position.held(rows.inputs.get("position", np.full(len(rows), np.nan)))
        table, table_sd = self._table_error(position[:, None], estimates, z, P_z)
        variance = variances(elongation[:, None], P)[:, 0] + (estimates.doubt_um**2).sum(axis=1)
        return Track(
            view.x_mm,
            view.bodies,
            self._rig.names,
            time_s=rows.time_s,
            mode=modes(fused, self._rig),
            elongation_um=um * (elongation * x).sum(axis=1),
            sigma_um=um * np.sqrt(variance),
            open_loop_um=um * grown_um,
            profile_C=z @ view.profile.T,
            profile_sd_K=np.sqrt(variances(view.profile, P_z)),
            bodies_C=z[:, view.at_bodies],
            error_at_table_um=table[:, 0],
            error_at_table_sd_um=table_sd[:, 0],
            measured=rows.channels,
            predicted=estimates.predicted,
            innovation=rows.channels - estimates.predicted,
            innovation_sd=estimates.sd,
            fused=fused,
            fault=estimates.fault,
            since_s=estimates.since_s,
            may_drift_K=estimates.may_drift_K,
            lacks_K=estimates.lacks_K,
            unsure_um=um * estimates.unsure_um,
            off_share=estimates.off_share,
            shift_mm=estimates.shift_mm,
            jump=estimates.jump,
            input_fault=estimates.input_fault,
            begins=np.zeros(len(rows), dtype=bool),
            open_loop=estimates.alone + self._zeros,
            nis=estimates.nis,
            nis_channels=fused.sum(axis=1),
            position_mm=position,
        )

    def table_errors(self, at_mm: Array, estimates: Estimates) -> TableErrors:
        """The error at the table, were it at places (p,) mm, of the ticks that were tracked last."""
        if not len(at_mm):
            return TableErrors.waiting(at_mm, len(estimates.x))
        return TableErrors(at_mm, *self._table_error(at_mm, estimates, *self._temperatures(estimates)))

    def _temperatures(self, estimates: Estimates) -> tuple[Array, Array]:
        """Temperatures (K, n) and their covariance (K, n, n), what they are in doubt by counted in."""
        at = self._state.temperatures
        doubt = estimates.doubt[:, at]
        return estimates.x[:, at], estimates.P[:, at, at] + doubt @ doubt.mT

    def _table_error(self, at_mm: Array, estimates: Estimates, z: Array, P_z: Array) -> tuple[Array, Array]:
        """Growth since the start by weights w of View.table_error at (p,), or (K, p), mm, and its sd: (K, p) um each.

        growth (1 + e), e the error of the expansion coefficient;   var = w' P_z w + growth^2 P_e + (sum(w) zero_sd)^2,
        and what the mounting of the screw adds; less the growth of the bed, where the rig has one
        """
        weights = self._view.table_error(at_mm)
        at = self._state.expansion
        rise = z - self._run.zero
        growth = (weights * rise[:, None]).sum(axis=-1)
        variance = variances(weights, P_z) + growth**2 * estimates.P[:, at, at, None]
        variance += (weights.sum(axis=-1) * self._rig.zero_sd_K) ** 2
        bed_um, bed_sd_um = self._bed.um(at_mm)
        variance += self._mounting.variance(at_mm, rise) + bed_sd_um**2
        return growth * (1.0 + estimates.x[:, at, None]) - bed_um, np.sqrt(variance)


def modes(fused: Array, rig: Rig) -> Array:
    """What estimates rest on whose fused channels are (..., m): a Mode each."""
    thermometers = rig.is_thermometer
    warm, other = fused[..., thermometers].any(axis=-1), fused[..., ~thermometers].any(axis=-1)
    return np.where(other, Mode.UPDATE, np.where(warm, Mode.PREDICT, Mode.COASTING))
