"""What temperatures may do while nothing is heard of the drive: the screw may have stood or turned all the time."""

import numpy as np

from estimator.network.layout import Layout
from estimator.record import Array

LEVEL, ALONG, BODY = 0.2, 0.5, 0.5  # K/sqrt(s): a drive at 20 m/min warms the screw by 5 K in 4 min, its ends by 15 K
SMOOTH_MM = 200.0
ROUGH = 0.05  # of what differs along the screw


def unknown_heat(place: Layout, tick_s: float) -> Array:
    """Covariance (n, n) K^2 that a tick adds: a level, a smooth deviation along the screw, and each body's own.

    Readings after a silence then find the profile anew, and what had grown at the start stays known.
    """
    n, knots = place.size, len(place.knots_mm)
    cov = np.diag(np.full(n, BODY**2))
    apart = place.knots_mm[:, None] - place.knots_mm[None, :]
    smooth = np.exp(-0.5 * (apart / SMOOTH_MM) ** 2) + ROUGH**2 * np.eye(knots)
    cov[:knots, :knots] = LEVEL**2 + ALONG**2 * smooth
    return cov * tick_s
