"""What is asked of a review first, in a line each: how much, how sure, which channel, is the model right, where not."""

import numpy as np

from estimator.accuracy.machine import LIMIT_SD
from estimator.accuracy.review import Review
from estimator.faults.fault import MAY_DRIFT
from estimator.faults.sentences import place_of
from estimator.inputs.phase import phase_of
from estimator.model import Model
from estimator.record import Array
from estimator.rig import Rig
from viz.drawing.scale import clock

WHEN = {"drive": "driving", "early_stop": "just stopped", "late_stop": "at rest"}


def glance(r: Review, rig: Rig, model: Model, at_s: float) -> str:
    """Markdown; `at_s` is the moment that views open at."""
    lines = [_grown(r, at_s), _sure(r), _table(r, at_s), _channels(r, rig), *_model(r, rig), _effects(model)]
    return "\n".join(f"- {line}" for line in lines if line)


def _grown(r: Review, at_s: float) -> str:
    um, sd, time_s = r.track.elongation_um, r.track.sigma_um, r.track.time_s
    if not np.isfinite(um).any():
        return ""
    k, most = int(np.searchsorted(time_s, at_s)), int(np.nanargmax(um))
    now = f"**Grown {um[k]:.1f} ± {2 * sd[k]:.1f} µm** at {clock(at_s)}"
    return f"{now}, at most {um[most]:.1f} µm at {clock(time_s[most])}"


def _sure(r: Review) -> str:
    if not np.isfinite(r.track.sigma_um).any():
        return ""
    widest = f"**Sure to ± {2 * np.nanmax(r.track.sigma_um):.2f} µm** (2 sd) or better"
    a = r.accuracy("filter")
    return f"{widest}; {100 * a.coverage_2sigma:.0f} % of errors inside" if np.isfinite(a.coverage_2sigma) else widest


def _table(r: Review, at_s: float) -> str:
    if not np.isfinite(r.table.error_um).any():
        return ""
    k = int(np.searchsorted(r.track.time_s, at_s))
    worst = int(np.nanargmax(np.abs(r.table.error_um[k])))
    off, sd = r.table.error_um[k, worst], r.table.sd_um[k, worst]
    return f"**At the table** {off:+.1f} ± {2 * sd:.1f} µm, where it is most: at {r.table.at_mm[worst]:.0f} mm"


def _channels(r: Review, rig: Rig) -> str:
    bad = [f"{place_of(rig, rig.index(one.channel))} {one.suspect.word}" for one in r.use.suspects]
    bad += [
        f"{place_of(rig, rig.index(one.channel))} {MAY_DRIFT}"
        for one in r.use.channels
        if one.suspicions and not one.suspect
    ]
    known = {name: nis for name, nis in r.nis_of.items() if np.isfinite(nis)}
    loud = max(known, key=lambda name: known[name], default="")
    most = f"; {loud} surprises most, {np.sqrt(known[loud]):.2f} sd" if loud else ""
    return f"**Bad channels: {', '.join(bad) or 'none'}**{most}"


def _model(r: Review, rig: Rig) -> list[str]:
    """Whether the model is right, and where and when it alone is furthest off."""
    right = "not told by this recording"
    if np.isfinite(r.off_sd):
        right = (
            f"{'no' if r.off_sd > LIMIT_SD else 'yes'}, alone {r.off_sd:.1f} of its sd off ({LIMIT_SD:.1f} is chance)"
        )
    heat = rig.is_thermometer
    apart = np.where(r.track.fused, r.track.measured - r.track.open_loop, np.nan)[:, heat]
    if not np.isfinite(apart).any():
        return [f"**Model right: {right}**"]
    k, i = np.unravel_index(int(np.nanargmax(np.abs(apart))), apart.shape)
    place, phase = place_of(rig, int(np.flatnonzero(heat)[i])), WHEN[phase_of(r.recording)[k]]
    when = f"{clock(r.track.time_s[k])} ({phase})"
    return [f"**Model right: {right}**", f"**Fails most** at {place}, {when}: {apart[k, i]:+.2f} K; {_worst(r)}"]


def _worst(r: Review) -> str:
    error: Array = r.errors["filter"]
    if not np.isfinite(error).any():
        return "no reference of the elongation"
    k = int(np.nanargmax(np.abs(error)))
    return f"filter {error[k]:+.2f} µm at {clock(r.track.time_s[k])}"


def _effects(model: Model) -> str:
    return f"**Effects: {len(model.effects)}**, of one model, {model.name}; what a new one changes: `ballscrew compare`"
