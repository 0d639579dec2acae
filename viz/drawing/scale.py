"""Ranges and colour maps, all taken from the data; and how a time since the start reads."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimator.record import Array

Range = tuple[float, float]
Anchors = tuple[tuple[int, int, int], ...]  # of a map of colours
Colours = NDArray[np.uint8]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]

MINUTE_S = 60.0
LABEL_APART = 25.0  # points between labels of an upright axis, fewer of which the viewer draws none
TIMES_APART, TIME_STEPS_S = 65.0, (1.0, 10.0, 60.0, 600.0, 3600.0, 43200.0, 86400.0, 864000.0)  # of a time axis
EDGE = 0.02  # of an axis
WARM = ((75, 3, 161), (139, 10, 165), (185, 50, 137), (219, 92, 104), (244, 136, 73), (254, 188, 43), (240, 249, 33))
DIVERGING = ((150, 215, 255), (45, 115, 220), (34, 34, 38), (215, 85, 30), (255, 210, 100))
UNKNOWN = (88, 88, 94)


@dataclass(frozen=True)
class BodyScale:
    """Ranges of profile and screw."""

    temperature_C: Range
    elongation_um: Range


def clock(time_s: float) -> str:
    """Time since the start as h:mm:ss."""
    minutes, seconds = divmod(round(time_s), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{seconds:02d}"


def extent_of(*arrays: Array) -> Range:
    """Lowest and highest of all values that are known."""
    known = [np.isfinite(array) for array in arrays]
    if not any(one.any() for one in known):
        return 0.0, 1.0
    lowest = min(np.min(array, where=one, initial=np.inf) for array, one in zip(arrays, known, strict=True))
    highest = max(np.max(array, where=one, initial=-np.inf) for array, one in zip(arrays, known, strict=True))
    return float(lowest), float(highest)


def widened(extent: Range, least: float) -> Range:
    """The extent, or as much as `least` around its middle: noise shall not fill a plot."""
    more = max(least - (extent[1] - extent[0]), 0.0) / 2
    return extent[0] - more, extent[1] + more


def step_of(span: float, pieces: int = 5) -> float:
    """Distance between ticks, 1, 2 or 5 times a power of ten, for about `pieces` of them."""
    raw = max(span, 1e-9) / pieces
    power = 10.0 ** np.floor(np.log10(raw))
    return float(power * next(m for m in (1, 2, 5, 10) if m * power >= raw * 0.999))


def rounded(extent: Range, pieces: int = 12) -> Range:
    """The extent rounded outwards to whole ticks."""
    step = step_of(extent[1] - extent[0], pieces)
    lo, hi = np.floor(extent[0] / step + 1e-9) * step, np.ceil(extent[1] / step - 1e-9) * step
    return float(lo), float(hi if hi > lo else lo + step)


def labelled(extent: Range, height: float) -> Range:
    """The extent, or as little more as gives an axis of a plot `height` points high two labels.

    The viewer labels multiples of a power of ten, the finest that stand far enough apart.
    """
    lo, hi = extent
    found = []
    for step in 10.0 ** np.arange(
        np.floor(np.log10(max(hi - lo, 1e-9))) - 1, np.ceil(np.log10(max(hi - lo, 1e-9))) + 2
    ):
        for first in np.floor([lo / step, lo / step + 1, hi / step - 1]) * step:
            ends = float(min(lo, first)), float(max(hi, first + step))
            if height * step >= LABEL_APART * (ends[1] - ends[0]):
                found.append(ends)
    lo, hi = min(found, key=lambda ends: ends[1] - ends[0])
    return lo - EDGE * (hi - lo), hi + EDGE * (hi - lo)  # a label at an edge would be cut


def labelled_until(end_s: float, width: float) -> float:
    """Where at least a time axis from 0 on, `width` points long, must end to have a second label, s: at the finest step
    of the viewer's whose labels stand far enough apart."""
    return min(step for step in TIME_STEPS_S if step * width >= TIMES_APART * max(end_s, step))


def ticks_of(extent: Range, pieces: int = 5) -> Array:
    """Tick places inside an extent."""
    step = step_of(extent[1] - extent[0], pieces)
    first = np.ceil(extent[0] / step - 1e-9)
    return np.arange(first, np.floor(extent[1] / step + 1e-9) + 1) * step + 0.0  # no -0


def symmetric(values: Array) -> Range:
    """A range around zero that holds 99 % of the values, its end 1, 2 or 5 times a power of ten."""
    sizes = np.abs(values[np.isfinite(values)])
    end = step_of(float(np.quantile(sizes, 0.99)), 1) if len(sizes) else 1.0
    return -end, end


def sums(time_s: Array, values: Array, width_s: float = MINUTE_S, first_s: float | None = None) -> tuple[Array, Array]:
    """Sums over windows of a minute: begins (n,) s and sums (n, ...), not-known counting as nothing.

    The first window begins at `first_s`, by default at the first time.
    """
    first_s = float(time_s[0]) if first_s is None else first_s
    window = np.floor((time_s - first_s) / width_s).astype(int)
    total = np.zeros((window[-1] + 1, *values.shape[1:]))
    np.add.at(total, window, np.where(np.isfinite(values), values, 0.0))
    return first_s + np.arange(len(total)) * width_s, total


def minutes(
    time_s: Array, values: Array, width_s: float = MINUTE_S, first_s: float | None = None
) -> tuple[Array, Array]:  # fmt: skip
    """Means over the same windows; NaN where all is."""
    begins, total = sums(time_s, values, width_s, first_s)
    count = sums(time_s, np.isfinite(values), width_s, first_s)[1]
    return begins, np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0)


def rms(values: Array) -> Array:
    """Of each column of (n, m), (m,); NaN where nothing is known."""
    known = np.isfinite(values).sum(axis=0)
    return np.sqrt(np.divide(np.nansum(values**2, axis=0), known, out=np.full(len(known), np.nan), where=known > 0))


def coloured(values: ArrayLike, extent: Range, anchors: Anchors = WARM) -> Colours:
    """Colours (..., 4) of values on a map; what is beyond the extent takes its end, NaN a grey that no map has."""
    place = (np.asarray(values, dtype=float) - extent[0]) / (extent[1] - extent[0])
    at = np.clip(place, 0.0, 1.0) * (len(anchors) - 1)
    channels = [np.interp(at, np.arange(len(anchors)), [anchor[i] for anchor in anchors]) for i in range(3)]
    colours = np.stack([*channels, np.full(at.shape, 255.0)], axis=-1)
    colours[~np.isfinite(place)] = (*UNKNOWN, 255)
    return colours.astype(np.uint8)
