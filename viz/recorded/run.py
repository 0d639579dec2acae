"""A run: one recording with everything that was estimated from it, ready to be shown."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from estimator.faults.fault import Fault
from estimator.inputs.phase import stops, turns
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.step import TableErrors, Track
from viz.drawing.scale import BodyScale, Flags, Range, extent_of, minutes, rounded, symmetric, widened
from viz.lanes.standing import Judged

READINGS = "readings"  # the reference where the truth is not known
JUDGED = ("filter", "polyline")  # the estimates that see the thermometers


@dataclass(frozen=True)
class Scale(BodyScale):
    """Ranges of one run's views: what the data needs, rounded outwards."""

    error_um: Range | None  # None: nothing to judge the estimates by
    innovation_K: Range  # of means of a minute
    open_loop_K: Range
    each_K: Range  # of innovations at each tick, but for a few
    each_um: Range


@dataclass(frozen=True)
class ReviewedRun:
    """One reviewed recording of K ticks.

    name            shown as the title of its tab
    smoothed_um     (K,) elongation after the fact, from the readings before and after; smoothed_sd_um (K,)
    polyline_um     (K,) elongation by the polyline through the thermometers
    readings_um     (K,) displacement readings joined to the start, um; NaN where there is none
    level_um        (K,) their level over a minute, without their scatter; level_sd_um (K,) how well it is known
    reference_um    (K,) what the estimates are judged by; NaN where there is none
    reference_name  what the reference is: "truth", "readings"
    errors_um       (K,) reference minus estimate for "filter", "smoothed" and "polyline"; where the reference is a
                    reading that the filter used, its error is that of the prediction before it
    error_sd_um     (K,) the filter's own standard deviation of its error
    nis_of          mean square of each channel's innovations over their sd; NaN where none was fused
    table           the error at the table, over its stroke; no places where there is none
    headline        what is asked first, in markdown
    judged          validity and alarms wherever they change
    truth_C_rise    (K, thermometers) true temperature rise at the thermometers, K; None where it is not known
    table_truth_um  (K, p) true error at the table, likewise
    """

    name: str
    rig: Rig
    recording: Recording
    track: Track
    smoothed_um: Array
    smoothed_sd_um: Array
    polyline_um: Array
    readings_um: Array
    level_um: Array
    level_sd_um: Array
    reference_um: Array
    reference_name: str
    errors_um: Mapping[str, Array]
    error_sd_um: Array
    nis_of: Mapping[str, float]
    table: TableErrors
    headline: str
    judged: Sequence[Judged]
    truth_C_rise: Array | None = None
    table_truth_um: Array | None = None

    def judged_um(self, estimate: str) -> Array:
        """The estimate that the reference was compared with, (K,) um."""
        return self.reference_um - self.errors_um[estimate]

    @property
    def is_judged(self) -> bool:
        """Whether there is a reference at all."""
        return bool(np.isfinite(self.reference_um).any())

    @property
    def lanes(self) -> int:
        """How many things are told of over time: motion, mode, thermometers used, whether the estimate is valid, alarms
        as a whole and each kind of alarm of channels."""
        return 3 + len({lane for judged in self.judged for lane in judged.states})

    @property
    def read(self) -> Flags:
        """(K,) whether the filter used a reading of a length."""
        return np.asarray(self.track.fused[:, ~self.rig.is_thermometer].any(axis=1))

    @property
    def turning(self) -> Flags:
        """(K,) whether the screw turned in the tick."""
        return np.asarray(turns(self.recording.omega))

    @property
    def first_stop_s(self) -> float:
        """The moment that shows most at a glance."""
        return first_stop_s(self.recording)

    @cached_property
    def scale(self) -> Scale:
        """Ranges that hold the whole run."""
        track, heat = self.track, self.rig.is_thermometer
        lengths = (track.elongation_um, track.open_loop_um, self.polyline_um, self.readings_um, self.reference_um)
        well = (track.fault == Fault.NONE)[:, heat]  # what is broken would stretch all of it
        measured, innovation = (np.where(well, a[:, heat], np.nan) for a in (track.measured, track.innovation))
        return Scale(
            temperature_C=rounded(widened(extent_of(measured, track.profile_C), 1.0)),
            elongation_um=rounded(widened(extent_of(*lengths), 1.0)),
            error_um=rounded(extent_of(*(self.errors_um[name] for name in JUDGED))) if self.is_judged else None,
            innovation_K=symmetric(minutes(track.time_s, innovation)[1]),
            each_K=symmetric(innovation),
            each_um=symmetric(track.innovation[:, ~heat][1:]),
            open_loop_K=symmetric(minutes(track.time_s, measured - track.open_loop[:, heat])[1]),
        )


def first_stop_s(recording: Recording) -> float:
    """The whole second after the first stop; without a stop the middle."""
    moments = stops(recording)
    return float(np.floor(moments[0]) + 1 if moments else np.ceil(np.nanmedian(recording.time_s)))
