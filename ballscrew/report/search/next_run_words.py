"""The run to make next, in words and as JSON."""

from __future__ import annotations

from typing import Any

from estimator.next_run.next_run import NextRun
from estimator.next_run.plans import Plan
from estimator.rig import Rig

APART_SD = 3.0  # a run that sets rivals less apart does not tell
NONE_TELLS = "No run of the patterns, speeds and levels seen would"


def next_run_sentence(run: NextRun | None, rig: Rig) -> str:
    """What to do about what is open; "" where nothing is, or nothing would help."""
    if run is None:
        return ""
    if run.separation_sd < APART_SD:
        return _no_run(run)
    plan, sd = plan_words(run.plan, rig), f"{run.separation_sd:.0f} sd"
    if run.why == "tie":
        return f"{plan} sets them {sd} apart{_least(run)}."
    if run.why == "unexplained":
        return f"{plan} sets these {sd} apart{_least(run)}."
    if run.why == "pair":
        return f"{plan} sets both {sd} apart from {run.between[1]}."
    if run.why == "badly known":
        return f"{run.between[0]} is badly known; {_small(plan)} would tell it from nothing by {sd}."
    if run.why == "not proven":
        return f"{run.between[0]} may be, and is not proven; {_small(plan)} would show it by {sd}."
    if run.why == "partly":
        return f"Of what was tried {run.between[0]} leaves least; {_small(plan)} would show it by {sd}."
    return f"{plan} would show it by {sd}."


def plan_words(plan: Plan, rig: Rig) -> str:
    """A run FS (0 - 400 mm) at 20 m/min, 10 min of drive and 60 min of stop."""
    drive, stop = f"{plan.drive_s / 60:.0f} min", f"{plan.stop_s / 60:.0f} min"
    if plan.stroke_mm is None:
        on = " and ".join(f"{name} at {level:g} {rig.inputs[name].unit}" for name, level in plan.levels.items())
        return f"A run with {on}, {drive} on and {stop} off"
    low, high = plan.stroke_mm
    speed = f"{plan.speed_m_min:g} m/min"
    return f"A run {plan.pattern} ({low:.0f} - {high:.0f} mm) at {speed}, {drive} of drive and {stop} of stop,"


def next_run_json(run: NextRun | None) -> dict[str, Any] | None:
    """The run for programs."""
    if run is None:
        return None
    plan = run.plan
    return {
        "pattern": plan.pattern, "speed_m_min": plan.speed_m_min, "drive_s": plan.drive_s, "stop_s": plan.stop_s,
        "separation_sd": run.separation_sd, "stroke_mm": plan.stroke_mm, "levels": dict(plan.levels), "why": run.why,
        "between": list(run.between),
    }  # fmt: skip


def _no_run(run: NextRun) -> str:
    """Said of rivals; an effect that no run tells from a change of the model's own parameters is not worth a word."""
    return f"{NONE_TELLS} tell {run.between[0]} from {run.between[1]}." if run.why in ("tie", "unexplained") else ""


def _least(run: NextRun) -> str:
    return f" or more, {run.between[0]} and {run.between[1]} least" if run.several else ""


def _small(plan: str) -> str:
    return plan[0].lower() + plan[1:]
