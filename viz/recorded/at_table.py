"""The error at the table: how much the screw has grown between the anchor bearing and the nut, over the stroke and over
time, and what the filter leaves of it. It is what a control compensates.
"""

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from estimator.record import Array
from viz.drawing import paths, profile, views
from viz.drawing.entity import Entity
from viz.drawing.frames import Axes
from viz.drawing.scale import Range, extent_of, rounded, widened
from viz.recorded.run import ReviewedRun

OVER_STROKE, OVER_TIME, LEFT = "over_stroke", "over_time", "left"
VIEW = 600.0, 600.0  # points, of the frame over the stroke
HIGH = 240.0  # of the axes over time
LINE = 22.0
LEAST_UM = 1.0


def is_known(run: ReviewedRun) -> bool:
    """Whether the table has a stroke, and an error along it."""
    return len(run.table.at_mm) > 1 and bool(np.isfinite(run.table.error_um).any())


def send(at: Entity, run: ReviewedRun) -> None:
    """Log the error over the stroke, and over time at both ends of it and in its middle, as often as profiles."""
    at, table, time_s = at / paths.AT_TABLE, run.table, run.track.time_s
    _frame(at / OVER_STROKE, run)
    shown, stroke = profile.picture_ticks(time_s, table.error_um), at / OVER_STROKE
    axes = axes_of(run)
    for some in profile.pieces(shown):
        profile.send_banded(stroke, axes, table.at_mm, time_s[some], table.error_um[some], table.sd_um[some])
        if run.table_truth_um is not None:
            places = axes.place(table.at_mm, run.table_truth_um[some]).astype(np.float32)
            (stroke / "truth").rows(time_s[some], rr.LineStrips2D.columns(strips=places))
    time_s, error, sd = time_s[shown], table.error_um[shown], table.sd_um[shown]
    for i, colour in zip(_ends(run), (paths.FILTER, paths.SMOOTHED, paths.POLYLINE), strict=True):
        name = f"table at {table.at_mm[i]:.0f} mm"
        (at / OVER_TIME / str(i)).band(f"{name} ±2 sd", colour)
        (at / OVER_TIME / str(i)).banded(time_s, error[:, i], sd[:, i])
        if run.table_truth_um is not None:
            (at / LEFT / str(i)).band(f"{name} ±2 sd", colour)
            (at / LEFT / str(i)).banded(time_s, run.table_truth_um[shown, i] - error[:, i], sd[:, i])


def _frame(at: Entity, run: ReviewedRun) -> None:
    """Log axes, key and looks, once, and where the table is."""
    axes, points = axes_of(run), rr.Radius.ui_points
    axes.draw(at / "axes", "table position [mm]", x_pieces=8)
    truth = [("truth", paths.REFERENCE)] if run.table_truth_um is not None else []
    axes.key(at / "key", [("filter ±2 sd", paths.FILTER), ("table, and its stroke", paths.NUT), *truth])
    profile.style_banded(at)
    (at / "truth").log(rr.LineStrips2D.from_fields(radii=points(1.0), colors=paths.REFERENCE, draw_order=4.0))
    stroke = axes.place(extent_of(run.table.at_mm), axes.y[0])
    (at / "stroke").log(rr.LineStrips2D([stroke], radii=points(2.5), colors=paths.NUT, draw_order=2.5))
    (at / "table").log(rr.Points2D.from_fields(radii=points(6.0), colors=paths.NUT, draw_order=5.0))
    position, time_s = run.recording.inputs["position"], run.track.time_s
    shown = profile.picture_ticks(time_s, position[:, None])
    places = axes.place(position[shown], axes.y[0]).astype(np.float32)
    (at / "table").rows(time_s[shown], rr.Points2D.columns(positions=places))


def axes_of(run: ReviewedRun) -> Axes:
    """The frame over the stroke."""
    return Axes(extent_of(run.table.at_mm), _range(run), VIEW[0] / 1.2, VIEW[1] - 6.0 * LINE, LINE)


def _range(run: ReviewedRun) -> Range:
    table = run.table
    return rounded(widened(extent_of(table.error_um - 2 * table.sd_um, table.error_um + 2 * table.sd_um), LEAST_UM))


def _ends(run: ReviewedRun) -> list[int]:
    """The lowest position, the middle one, and the highest."""
    order = np.argsort(run.table.at_mm)
    return [int(order[0]), int(order[len(order) // 2]), int(order[-1])]


def _left(run: ReviewedRun, truth_um: Array) -> Range:
    """Range of errors with their bands, but for the widest ones."""
    left, band = (truth_um - run.table.error_um)[:, _ends(run)], 2 * run.table.sd_um[:, _ends(run)]
    most = np.nanquantile(np.abs(left) + band, 0.99)
    return rounded((-float(most), float(most)))


def page(root: str, run: ReviewedRun) -> rrb.Container:
    """The views that show it."""
    at, span = f"{root}/{paths.AT_TABLE}", views.whole(run.track.time_s)
    title = "Thermal error over the stroke, anchor bearing to nut [µm over mm]"
    stroke = views.flat(f"{at}/{OVER_STROKE}", title, axes_of(run).bounds)
    name = "Thermal error at the table [µm]"
    curves = [views.beside_legend(f"{at}/{OVER_TIME}", name, span, _range(run), HIGH)]
    if run.table_truth_um is not None:
        name, extent = "What the filter leaves of it: truth − filter [µm]", _left(run, run.table_truth_um)
        curves.append(views.beside_legend(f"{at}/{LEFT}", name, span, extent, HIGH))
    return rrb.Horizontal(stroke, rrb.Vertical(*curves), column_shares=[5, 6], name="At the table")
