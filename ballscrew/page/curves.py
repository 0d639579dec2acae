"""Pictures of one reviewed recording over time: elongation, what the estimate leaves, the error at the table."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ballscrew.page.colours import DRAWN
from ballscrew.page.picture import curve, dots, legend, shade, sheet
from ballscrew.page.section import Picture
from estimator.accuracy.review import Review
from estimator.inputs.phase import phases

SEVERAL = ("filter", "polyline", "alone", "smoothed", "reading", "bad")  # colours of curves of one kind
GROUND = "grey ground: driving"


def pictures(review: Review) -> Iterator[Picture]:
    """Those that the recording has something for."""
    if np.isfinite(review.track.elongation_um).any():
        yield elongation(review)
    if np.isfinite(review.errors["filter"]).any():
        yield errors(review)
    if np.isfinite(review.table.error_um).any():
        yield at_the_table(review)


def elongation(review: Review) -> Picture:
    """The estimate with its band, the model alone, reference and readings."""
    minutes, track = review.recording.time_s / 60, review.track
    with sheet(2.9) as drawn:
        axes = drawn.figure.subplots()
        shade(axes, review.recording)
        if review.reference_name == "truth":
            curve(axes, minutes, review.reference, "ink", "truth")
        if np.isfinite(review.readings.um).any():
            dots(axes, minutes, review.readings.um, "reading", "readings")
        curve(axes, minutes, track.open_loop_um, "alone", "model alone")
        curve(axes, minutes, track.elongation_um, "filter", "filter", track.sigma_um)
        axes.set(xlabel="time, min", ylabel="elongation, µm")
        legend(axes)
    return drawn.picture(f"{review.recording.name}: elongation of the measured span; {GROUND}.")


def errors(review: Review) -> Picture:
    """Reference minus estimate, with what the estimate says of itself."""
    minutes, sd = review.recording.time_s / 60, review.sigma["filter"]
    with sheet(2.5) as drawn:
        axes = drawn.figure.subplots()
        shade(axes, review.recording)
        axes.axhline(0.0, color=DRAWN["faint"], linewidth=0.8)
        known = np.where(np.isfinite(review.errors["filter"]), sd, np.nan)
        at = np.flatnonzero(np.isfinite(known))[:: max(1, len(known) // 1000)]
        axes.fill_between(
            minutes[at], -2 * known[at], 2 * known[at], color=DRAWN["filter"], alpha=0.25, lw=0, label="± 2 sd"
        )  # fmt: skip
        show = curve if review.reference_name == "truth" else dots
        if np.isfinite(review.errors["smoothed"]).any():
            show(axes, minutes, review.errors["smoothed"], "smoothed", "smoothed, after the fact")
        show(axes, minutes, review.errors["filter"], "filter", "filter")
        axes.set(xlabel="time, min", ylabel="reference - estimate, µm")
        legend(axes)
    return drawn.picture(f"{review.recording.name}: reference ({review.reference_name}) minus estimate; {GROUND}.")


def at_the_table(review: Review) -> Picture:
    """The error where the table is, over time, and where it may be, at the ends of drives and rests."""
    minutes, track, table = review.recording.time_s / 60, review.track, review.table
    with sheet(2.7) as drawn:
        left, right = drawn.figure.subplots(1, 2, width_ratios=(2, 1), sharey=True)
        shade(left, review.recording)
        curve(left, minutes, track.error_at_table_um, "filter", "filter", track.error_at_table_sd_um)
        left.set(xlabel="time, min", ylabel="error at the table, µm")
        legend(left)
        places = np.argsort(table.at_mm)
        for k, colour in zip(_turns(review), SEVERAL, strict=False):
            mean, sd = table.error_um[k, places], table.sd_um[k, places]
            right.fill_between(table.at_mm[places], mean - 2 * sd, mean + 2 * sd, color=DRAWN[colour], alpha=0.25, lw=0)
            right.plot(table.at_mm[places], mean, color=DRAWN[colour], label=f"{minutes[k]:.0f} min")
        right.set_xlabel("table position, mm")
        legend(right, 2)
    caption = (
        "growth between the anchor bearing and the nut's centre, positive: longer; a control adds its negative. Left: "
        f"where the table is; {GROUND}. Right: over the stroke, at the end of each drive and rest, ± 2 sd."
    )
    return drawn.picture(f"{review.recording.name}: {caption}")


def _turns(review: Review) -> list[int]:
    """The last tick of each drive and of each rest after one."""
    found: list[int] = []
    for driving, ticks in phases(review.recording):
        if driving or found:
            found.append(int(ticks[-1]))
    return found
