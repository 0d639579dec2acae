"""A few smooth shapes instead of hundreds of cells: the reduced mesh.

The physics is written on a fine network (cells of 4 mm). The filter needs few states, so the profile between chosen
places, the knots, is a cubic spline: T(x) = sum_j z_j phi_j(x), with z_j the temperature at knot j. Galerkin projection
of the network on these shapes keeps heat exactly and is of fourth order in the spacing, so that knots at the
thermometers, at the bearings, in their seats and halfway in wide gaps agree with 500 linear cells to 0.05 um and 0.1 K.
"""

from functools import lru_cache
from itertools import pairwise

import numpy as np

from estimator.record import Array
from estimator.rig import Rig

WIDEST_MM = 85.0
CLOSEST_MM = 8.0
AT_BEARING_MM = 28.0  # the profile is steepest at a bearing: gaps start this wide there ...
GRADING = 0.58  # ... and may grow by half the distance from it
STRETCH = 0.01  # by which all gaps between two places may be wider


def knots(rig: Rig) -> Array:
    """Places of the states along the screw, mm: thermometers, bearings, ends, and what keeps gaps small."""
    screw = rig.screw
    assert screw is not None
    if screw.knots_mm:
        return np.array(sorted(screw.knots_mm))
    wanted = [c.at_mm for c in rig.channels.values() if c.at_mm is not None]
    places = sorted({screw.from_mm, screw.to_mm, *wanted})
    for bearing in rig.supports.values():
        if min(abs(bearing.at_mm - place) for place in places) > CLOSEST_MM:
            places = sorted([*places, bearing.at_mm])
    filled = [places[0]]
    for lo, hi in pairwise(places):
        filled.extend(_graded(lo, hi, rig))
    return np.array(_within_seats(filled, rig))


def _within_seats(places: list[float], rig: Rig) -> list[float]:
    """Gaps that a bearing's seat lies in, cut to half its width: a narrow seat is a peak of heat."""
    cut = places[:1]
    for lo, hi in pairwise(places):
        seats = [bearing.width_mm for bearing in rig.supports.values() if lo <= bearing.at_mm <= hi]
        cut.extend(_cut(lo, hi, max(min([width / 2 for width in seats], default=hi - lo), CLOSEST_MM)))
    return cut


def _cut(lo: float, hi: float, widest: float) -> list[float]:
    """Ends of equal gaps between lo and hi, none wider than that."""
    pieces = int(np.ceil((hi - lo) / widest))
    return list(lo + (hi - lo) * np.arange(1, pieces + 1) / pieces)


def _graded(lo: float, hi: float, rig: Rig) -> list[float]:
    """Ends of gaps between lo and hi that widen away from the nearest bearing, each as wide as it may be, or less.

    All may be a hundredth wider, where that saves one.
    """
    sides = [(max(lo - b.at_mm, b.at_mm - hi, 0.0), b.at_mm >= hi) for b in rig.supports.values()]
    away, above = min(sides, default=(WIDEST_MM / GRADING, False))
    widths = list[float]()
    while sum(widths) < (hi - lo) * (1.0 - STRETCH):
        widths.append(min(WIDEST_MM, AT_BEARING_MM + GRADING * (away + sum(widths))))
    inner = np.cumsum(widths[:-1]) * (hi - lo) / sum(widths)
    return [*(np.sort(hi - inner) if above else lo + inner).tolist(), hi]


def shapes(places_mm: Array, x_mm: Array) -> Array:
    """The splines phi_j at x, (len(x), knots): 1 at their own knot, 0 at the others.

    Their ends are free: whether heat crosses the end of the bar is for the network to say.
    """
    return _shapes(places_mm.astype(float).tobytes(), x_mm.astype(float).tobytes())


def slopes(places_mm: Array, x_mm: Array) -> Array:
    """First derivatives of the splines at x, 1/mm, (len(x), knots)."""
    return _shapes(places_mm.astype(float).tobytes(), x_mm.astype(float).tobytes(), 1)


@lru_cache(maxsize=1024)
def _shapes(places_mm: bytes, x_mm: bytes, derivative: int = 0) -> Array:
    """The same of arrays as bytes: the places of thermometers are asked for again and again.

    Between two knots z, s d their values and slopes, t = (x - left) / d:
    z0 + t (s0 d + t (3 dz - (2 s0 + s1) d + t ((s0 + s1) d - 2 dz)))
    """
    places, x = np.frombuffer(places_mm), np.frombuffer(x_mm)
    left = np.clip(np.searchsorted(places, x, side="right") - 1, 0, len(places) - 2)
    d, z = np.diff(places)[left][:, None], np.eye(len(places))
    s0, s1 = (_knot_slopes(places_mm)[left + k] * d for k in (0, 1))
    t, z0, dz = (x[:, None] - places[left][:, None]) / d, z[left], z[left + 1] - z[left]
    square, cube = 3.0 * dz - 2.0 * s0 - s1, s0 + s1 - 2.0 * dz
    found = (
        z0 + t * (s0 + t * (square + t * cube)) if derivative == 0 else (s0 + t * (2.0 * square + 3.0 * t * cube)) / d
    )
    found.flags.writeable = False
    return found


@lru_cache(maxsize=64)
def _knot_slopes(places_mm: bytes) -> Array:
    """Slopes of the splines at the knots, 1/mm, (knots, knots): each spline and its first two derivatives go on
    evenly, and next to the ends the third as well ("not a knot"). scipy has this spline, and takes 0.2 s to import."""
    places = np.frombuffer(places_mm)
    d, n = np.diff(places), len(places)
    steep = np.diff(np.eye(n), axis=0) / d[:, None]
    if n == 2:
        return np.repeat(steep, 2, axis=0)
    A, b, inner = np.zeros((n, n)), np.zeros((n, n)), np.arange(1, n - 1)
    A[inner, inner - 1], A[inner, inner], A[inner, inner + 1] = d[1:], 2.0 * (d[1:] + d[:-1]), d[:-1]
    b[1:-1] = 3.0 * (d[1:, None] * steep[:-1] + d[:-1, None] * steep[1:])
    for ends, gap, beside in (((0, 1), 0, 1), ((-1, -2), -1, -2)):
        both = d[gap] + d[beside]
        A[ends[0], ends] = (d[beside], both) if n > 3 else (1.0, 1.0)  # of three knots one parabola
        b[ends[0]] = ((d[gap] + 2.0 * both) * d[beside] * steep[gap] + d[gap] ** 2 * steep[beside]) / both
        b[ends[0]] = b[ends[0]] if n > 3 else 2.0 * steep[gap]
    return np.linalg.solve(A, b)
