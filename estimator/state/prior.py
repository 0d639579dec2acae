"""What is known of the temperatures before the first reading."""

from collections.abc import Mapping, Sequence

import numpy as np

from estimator.inputs.start import Start
from estimator.network.layout import Layout
from estimator.record import Array
from estimator.terms import Store, Term

LEVEL_SD_K = 0.3
BODY_SD_K = 0.3
UNKNOWN_BODY_SD_K = 2.0
SMOOTH_MM = 200.0


def prior(start: Start, terms: Sequence[Term], place: Layout, inputs: Mapping[str, float]) -> tuple[Array, Array]:
    """Mean (n,) and covariance (n, n) of the temperatures before the first reading, by inputs as first measured.

    Along the screw the profile is the level plus a smooth deviation as large as the spread of the thermometers
    (a Gaussian process with 200 mm correlation length), so that the first readings interpolate between themselves.
    """
    n, knots = place.size, len(place.knots_mm)
    mean, cov = np.full(n, start.level_C), np.zeros((n, n))
    apart = place.knots_mm[:, None] - place.knots_mm[None, :]
    deviation = max(0.02, start.spread_K)
    cov[:knots, :knots] = LEVEL_SD_K**2 + deviation**2 * np.exp(-0.5 * (apart / SMOOTH_MM) ** 2)
    cov[np.arange(knots), np.arange(knots)] += (0.05 * deviation) ** 2
    for term in terms:
        if isinstance(term, Store) and term.node in place.bodies:
            i = place.state(term.node)
            reading = inputs.get(term.start, np.nan) - start.zero_K.get(term.start, 0.0) if term.start else np.nan
            mean[i] = reading if np.isfinite(reading) else start.level_C
            cov[i, i] = (BODY_SD_K if np.isfinite(reading) else UNKNOWN_BODY_SD_K) ** 2
    return mean, cov
