"""How sure the filter is, and whether it is right about that: its error within two standard deviations, on an axis of
its own, what share of it is inside when, and the deviations over time.
"""

from collections.abc import Mapping

import numpy as np
import rerun.blueprint as rrb

from estimator.inputs.phase import phase_of
from estimator.record import Array
from viz.drawing import bars, paths, views
from viz.drawing.bars import Bars, BarSeries
from viz.drawing.entity import Entity
from viz.drawing.scale import Range, extent_of
from viz.recorded.run import READINGS, ReviewedRun

HONEST = 0.95  # of errors inside two sd, when these are what they say
ROOM = 0.2  # of the span, for a legend in the whole width
LEAST_UM = 1e-3
HIGH, LOW = 190.0, 140.0  # points, of the axes of errors and of their sd
NEAR = 0.002  # shares of errors, lowest and highest, that the axis need not hold
TITLE = f"Share of errors inside ±2 sd [1]; red: below {HONEST}"
PARTS = {"drive": "driving", "early_stop": "10 min after stops", "late_stop": "later at rest"}
WIDE = 320  # pixels of the bars: four of them in a flat view


def send(at: Entity, run: ReviewedRun) -> None:
    """Log errors, their sd and the share inside two of them, once."""
    time_s, track, error, sd = run.track.time_s, run.track, run.errors_um["filter"], run.error_sd_um
    curve = at / paths.SURE
    (curve / "band").band("±2 sd of the difference", paths.BAND_EDGE, 0.5)
    (curve / "error").lines([f"{run.reference_name} − filter [µm]"], [paths.REFERENCE], 1.5, "MinMax")
    (curve / "outside").dots("outside [µm]", paths.LEFT_OUT, 2.5)
    (curve / "band").banded(time_s, np.zeros(len(time_s)), np.where(np.isfinite(error), sd, np.nan))
    (curve / "error").known(time_s, error)
    (curve / "outside").known(time_s, np.where(np.abs(error) > 2 * sd, error, np.nan))
    doubts = at / paths.SURE_SD
    both = sd if run.reference_name == READINGS else np.full(len(sd), np.nan)
    names = {"filter": track.sigma_um, "readings": run.level_sd_um, "both together": both}
    for (name, values), colour in zip(names.items(), (paths.FILTER, paths.READING, paths.REFERENCE), strict=True):
        if np.isfinite(values).any():
            (doubts / name.split()[0]).lines([f"{name} [µm]"], [colour], 1.5)
            (doubts / name.split()[0]).known(time_s, values)
    if run.is_judged:
        bars.send(at / paths.SURE_BARS, shares(run))


def shares(run: ReviewedRun) -> Bars:
    """The share of errors inside two sd, by what the machine was doing."""
    error, phase = run.errors_um["filter"], phase_of(run.recording)
    inside = np.abs(error) <= 2 * run.error_sd_um
    parts = {"all": np.isfinite(error)}
    parts |= {words: np.isfinite(error) & (phase == name) for name, words in PARTS.items()}
    return share_bars({words: float(inside[part].mean()) if part.any() else np.nan for words, part in parts.items()})


def share_bars(shares: Mapping[str, float]) -> Bars:
    """Shares inside two sd as bars, red where it is less than it should be."""
    found = np.array(list(shares.values()))
    short = found < HONEST
    pairs = ((f"{HONEST} and more", paths.FILTER, ~short), ("too sure", paths.LEFT_OUT, short))
    return Bars(TITLE, list(shares), [BarSeries(name, np.where(so, found, np.nan), at) for name, at, so in pairs], WIDE)


def is_known(run: ReviewedRun) -> bool:
    """Whether there is an elongation to be sure of: not on a rig without a screw."""
    return bool(np.isfinite(run.track.sigma_um).any())


def page(root: str, run: ReviewedRun) -> rrb.Container:
    """The views that show it."""
    span = views.whole(run.track.time_s)
    most = np.nanquantile(np.concatenate([run.error_sd_um, run.track.sigma_um, run.level_sd_um]), 1 - NEAR)
    extent = 0.0, max(float(most), LEAST_UM)
    sd = views.beside_legend(f"{root}/{paths.SURE_SD}", "Standard deviation [µm]", span, extent, LOW)
    if not run.is_judged:
        return rrb.Vertical(sd, name="How sure")
    found = shares(run)
    title = f"{run.reference_name} − filter [µm]: {np.nanmax(found.values[:, 0]):.1%} inside ±2 sd, 95 % when honest"
    error = views.plot(f"{root}/{paths.SURE}", title, span, _extent(run), room=ROOM, height=HIGH)
    share = views.flat(f"{root}/{paths.SURE_BARS}", TITLE, found.frame.bounds)
    below = rrb.Horizontal(sd, share, column_shares=[3, 2])
    return rrb.Vertical(error, views.state_view(root, span, ROOM), below, row_shares=[5, 3.4, 4], name="How sure")


def _extent(run: ReviewedRun) -> Range:
    """An axis that holds the band, and all errors but a few."""
    known = np.isfinite(run.errors_um["filter"])
    ends: list[Array] = [np.zeros(1)]
    for values in (run.errors_um["filter"][known], 2 * run.error_sd_um[known], -2 * run.error_sd_um[known]):
        if len(values):
            ends.append(np.nanquantile(values, [NEAR, 1 - NEAR]))
    half = max(LEAST_UM, *map(abs, extent_of(*ends)))
    return -half, half
