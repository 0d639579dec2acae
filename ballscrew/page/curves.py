"""Pictures of one reviewed recording over time: elongation, what the estimate leaves, the error at the table."""

from collections.abc import Iterator

import numpy as np

from ballscrew.page.picture import DRAWN, curve, dots, legend, shade, sheet
from ballscrew.page.section import Picture
from estimator.accuracy.review import Review
from estimator.inputs.phase import phases
from estimator.record import Array
from estimator.rig import Rig
from viz.drawing.scale import minutes, symmetric

SEVERAL = ("filter", "polyline", "alone", "smoothed", "reading", "bad")  # colours of curves of one kind
GROUND = "grey ground: driving"
COLD, WARM = (0.16, 0.42, 0.86), (0.88, 0.36, 0.10)
UNREAD = (0.5, 0.5, 0.5, 0.35)
SHADES = 257  # an odd number: one of them is nothing


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


def colours() -> Array:
    """From cold over nothing, where the page shows through, to warm: (shades, 4)."""
    share = np.linspace(-1.0, 1.0, SHADES)[:, None]
    return np.hstack([np.where(share < 0.0, COLD, WARM), np.abs(share)])


def residual_map(review: Review, rig: Rig) -> Picture | None:
    """What thermometers read minus what was expected of them, minute by minute, by filter and by model alone; None
    where nothing was read."""
    from matplotlib.colors import ListedColormap

    track, heat = review.track, rig.is_thermometer
    maps = {
        "one tick ahead": minutes(track.time_s, track.innovation[:, heat])[1],
        "the model alone": minutes(track.time_s, (track.measured - track.open_loop)[:, heat])[1],
    }
    if not np.isfinite(np.stack([*maps.values()])).any():
        return None
    ramp = ListedColormap(colours()).with_extremes(bad=UNREAD)
    names = [name for name, is_heat in zip(rig.names, heat, strict=True) if is_heat]
    with sheet(1.0 + 0.3 * len(names)) as drawn:
        grid = drawn.figure.subplots(2, 2, width_ratios=(60, 1))
        for (axes, bar), (title, values) in zip(grid, maps.items(), strict=True):
            low, high = symmetric(values)
            box = (0.0, float(len(values)), len(names) - 0.5, -0.5)
            axes.imshow(values.T, ramp, vmin=low, vmax=high, extent=box, aspect="auto", interpolation="none")
            axes.grid(visible=False)
            axes.set_title(title, fontsize=9, loc="left")
            axes.set_yticks(range(len(names)), names, fontsize=7)
            shades = np.linspace(low, high, SHADES)[:, None]
            bar.imshow(shades, ramp, origin="lower", extent=(0, 1, low, high), aspect="auto", interpolation="none")
            bar.set_xticks([])
            bar.grid(visible=False)
            bar.yaxis.tick_right()
            bar.set_title("K", fontsize=9)
        grid[1, 0].set_xlabel("time, min")
    return drawn.picture(
        f"{review.recording.name}: thermometers minus prediction, K, means of a minute; orange: warmer than expected; "
        "grey: not read."
    )
