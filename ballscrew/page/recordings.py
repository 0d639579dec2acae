"""Rig, recordings and channels as tables."""

from __future__ import annotations

from datetime import datetime

import numpy as np

from ballscrew.page.section import Grid, Section
from ballscrew.report.sections import number
from ballscrew.report.use_report import left_out
from ballscrew.reviewing import Reviewed
from ballscrew.terminal import Rows, duration
from estimator.accuracy.review import Review
from estimator.faults.fault import MAY_DRIFT
from estimator.inputs.phase import phases
from estimator.rig import Rig


def rig_and_recordings(found: Reviewed, rig: Rig) -> Section:
    """What was measured, where and when."""
    head = ["recording", "began", "length", "drives", "driven", "ticks", "frames", "reference", "in the model's fit"]
    fitted = zip(found.reviews, found.fitted, strict=True)
    rows = [head, *(_recording(review, used) for review, used in fitted)]
    without = [["left out as asked", ", ".join(found.without)]] if found.without else []
    blocks = [Grid([*_rig(rig, found.verdict.model.name), *without], prose=(1,)), Grid(rows)]
    return Section("Rig and recordings", blocks)


def _rig(rig: Rig, model: str) -> Rows:
    at = [c.at_mm for c in rig.channels.values() if c.at_mm is not None]
    places = f", {min(at):g} to {max(at):g} mm along it" if at else ""
    lengths = [name for name, channel in rig.channels.items() if not channel.is_thermometer]
    rows = [["rig", rig.name], ["model", model]]
    if (screw := rig.screw) is not None:
        span = "{:g} to {:g} mm".format(*screw.span_mm)
        lead = f"phi {screw.outer_mm:g} / {screw.bore_mm:g} mm, lead {screw.lead_mm:g} mm"
        rows.append(["screw", f"{lead}; elongation is that of {span}"])
    for name, support in rig.supports.items():
        rows.append([f"{name} bearing", f"at {support.at_mm:g} mm"])
    rows.append(["thermometers", f"{len(rig.thermometers)}{places}: {', '.join(rig.thermometers)}"])
    rows.append(["lengths", ", ".join(lengths) or "none"])
    return [*rows, ["inputs", ", ".join(rig.inputs)]]


def _recording(review: Review, fitted: bool) -> list[str]:
    r = review.recording
    began = "" if r.began_s is None else datetime.fromtimestamp(r.began_s).isoformat(" ", "minutes")
    tick_s = float(np.median(np.diff(r.time_s))) if len(r) > 1 else 0.0
    drives = [len(ticks) for driving, ticks in phases(r) if driving]
    told = [str(len(drives)), duration(sum(drives) * tick_s), str(len(r)), str(r.frames or "")]
    return [r.name, began, duration(r.time_s[-1]), *told, review.reference_name, "yes" if fitted else "no"]


def channels(review: Review, rig: Rig) -> Rows:
    """What was used of each channel, and how far it is from what was expected of it."""
    rows = [["channel", "at, mm", "used", "refused", "NIS", "suspect", "why not used"]]
    for one in review.use.channels:
        at = rig.channels[one.channel].at_mm
        share = f"{one.share:.1%}" if np.isfinite(one.share) else "never read"
        suspect = one.suspect.word or (MAY_DRIFT if one.suspicions else "")
        why = ", ".join(f"{count} x {reason}" for reason, count in one.why.items())
        place = "" if at is None else f"{at:g}"
        rows.append([one.channel, place, share, str(one.refused), number(review.nis_of[one.channel]), suspect, why])
    return rows


def failed(found: Reviewed, rig: Rig) -> list[Grid]:
    """When sensors were broken; nothing where none was."""
    rows = left_out([review.use for review in found.reviews], rig)
    return [Grid(rows, prose=(1, 2))] if rows else []
