"""Thermometers minus prediction as a picture: a row for each channel, a column for each minute."""

from __future__ import annotations

import numpy as np

from ballscrew.page.picture import sheet
from ballscrew.page.section import Picture
from estimator.accuracy.review import Review
from estimator.record import Array
from estimator.rig import Rig
from viz.drawing.scale import minutes, symmetric

COLD, WARM = (0.16, 0.42, 0.86), (0.88, 0.36, 0.10)
UNREAD = (0.5, 0.5, 0.5, 0.35)
SHADES = 257  # an odd number: one of them is nothing


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
