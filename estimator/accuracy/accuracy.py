"""How far an estimate is from its reference: always reference minus estimate."""

from dataclasses import dataclass

import numpy as np

from estimator.record import Array


@dataclass(frozen=True)
class Accuracy:
    """Errors of one estimate over some ticks, um.

    band_um            lowest and highest error; its width is the accuracy band
    rms_um
    cooldown_max_um    largest absolute error in the 60 min after a stop, NaN without one
    coverage_2sigma    share of errors inside +-2 sd, NaN where the estimate has no sd
    """

    band_um: tuple[float, float]
    rms_um: float
    cooldown_max_um: float = float("nan")
    coverage_2sigma: float = float("nan")

    def __str__(self) -> str:
        low, high = self.band_um
        return f"{low:+.2f} ... {high:+.2f} um, rms {self.rms_um:.2f}, after stops {self.cooldown_max_um:.2f}"

    @property
    def width_um(self) -> float:
        """The accuracy band: highest minus lowest."""
        return self.band_um[1] - self.band_um[0]


def accuracy(error: Array, sigma: Array | None = None, cooling: Array | None = None) -> Accuracy:
    """Accuracy of errors (K,) um, NaN where there is no reference; `cooling` (K,) bool marks 60 min after a stop."""
    known = np.isfinite(error)
    if not known.any():
        nan = float("nan")
        return Accuracy((nan, nan), nan)
    e = error[known]
    late = error[known & cooling] if cooling is not None else np.empty(0)
    inside = np.abs(e) <= 2 * sigma[known] if sigma is not None else np.empty(0)
    return Accuracy(
        (float(e.min()), float(e.max())),
        rms(e),
        float(np.abs(late).max()) if len(late) else float("nan"),
        float(inside.mean()) if len(inside) else float("nan"),
    )


def rms(error: Array) -> float:
    """Root mean square of what is known of an error, NaN where nothing is."""
    known = error[np.isfinite(error)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")


def least_squares_line(estimate: Array, reference: Array) -> tuple[float, float, tuple[float, float]]:
    """a, b of reference = a estimate + b (um), and the band of what remains; NaN with fewer than two points."""
    known = np.isfinite(estimate) & np.isfinite(reference)
    if known.sum() < 2:
        nan = float("nan")
        return nan, nan, (nan, nan)
    a, b = np.polyfit(estimate[known], reference[known], 1)
    rest = reference[known] - (a * estimate[known] + b)
    return float(a), float(b), (float(rest.min()), float(rest.max()))
