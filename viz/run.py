"""A run: one recording with everything that was estimated from it, ready to be shown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.step import Track
from viz import columns
from viz.columns import Indices

Flags = NDArray[np.bool_]

AT_REST = 0.5  # rad/s
JUDGED = ("filter", "polyline")  # the estimates that see the thermometers


@dataclass(frozen=True)
class Run:
    """One reviewed recording of K ticks.

    name            shown as the title of its tab
    polyline_um     (K,) elongation by the polyline through the thermometers
    readings_um     (K,) displacement readings joined to the start, um; NaN where there is none
    reference_um    (K,) what the estimates are judged by; NaN where there is none
    reference_name  what the reference is: "truth", "readings"
    errors_um       (K,) reference minus estimate for "filter" and "polyline"; where the reference is a reading that the
                    filter used, its error is that of the prediction before it
    error_sd_um     (K,) the filter's own standard deviation of its error
    truth_C_rise    (K, thermometers) true temperature rise at the thermometers, K; None where it is not known
    """

    name: str
    rig: Rig
    recording: Recording
    track: Track
    polyline_um: Array
    readings_um: Array
    reference_um: Array
    reference_name: str
    errors_um: Mapping[str, Array]
    error_sd_um: Array
    truth_C_rise: Array | None = None

    def judged_um(self, estimate: str) -> Array:
        """The estimate that the reference was compared with, (K,) um."""
        return self.reference_um - self.errors_um[estimate]

    @property
    def is_judged(self) -> bool:
        """Whether there is a reference at all."""
        return bool(np.isfinite(self.reference_um).any())

    @property
    def thermometers(self) -> Indices:
        """Columns of the thermometers among the channels, in order."""
        return columns.thermometers(self.rig)

    @property
    def on_screw(self) -> Indices:
        """Columns of the thermometers that have a place on the screw."""
        return columns.on_screw(self.rig)

    @property
    def places_mm(self) -> Array:
        """Places of those thermometers, mm."""
        return columns.places_mm(self.rig)

    @property
    def turning(self) -> Flags:
        """(K,) whether the screw turned in the tick."""
        return np.asarray(np.nan_to_num(self.recording.omega) > AT_REST)

    @property
    def stops_s(self) -> Array:
        """Times at which the drive stopped, s."""
        ends = np.flatnonzero(self.turning[:-1] & ~self.turning[1:]) + 1
        return self.track.time_s[ends]


def first_stop_s(run: Run) -> float:
    """The moment that shows most at a glance: the whole second after the first stop; without a stop the middle."""
    stops = run.stops_s
    return float(np.ceil(stops[0] if len(stops) else np.nanmedian(run.track.time_s)))
