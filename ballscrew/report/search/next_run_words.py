"""The run to make next, in words and as JSON."""

from typing import Any

from estimator.next_run.next_run import NextRun
from estimator.next_run.plans import Plan
from estimator.rig import Rig

APART_SD = 3.0  # a run that sets rivals less apart does not tell
NONE_TELLS = "No run of the patterns, speeds and levels seen would"
SAID = {  # what a run would do about each question
    "tie": "{plan} sets them {sd} apart{least}.",
    "unexplained": "{plan} sets these {sd} apart{least}.",
    "pair": "{plan} sets both {sd} apart from {other}.",
    "badly known": "{best} is badly known; {small} would tell it from nothing by {sd}.",
    "not proven": "{best} may be, and is not proven; {small} would show it by {sd}.",
    "partly": "Of what was tried {best} leaves least; {small} would show it by {sd}.",
    "one recording": "{plan} would show it by {sd}.",
}


def next_run_sentence(run: NextRun | None, rig: Rig) -> str:
    """What to do about what is open; "" where nothing is, or nothing would help."""
    if run is None:
        return ""
    if run.separation_sd < APART_SD:  # an effect that no run tells from a change of own parameters is not worth a word
        rivals = run.why in ("tie", "unexplained")
        return f"{NONE_TELLS} tell {run.between[0]} from {run.between[1]}." if rivals else ""
    best, *others = run.between
    plan = plan_words(run.plan, rig)
    least = f" or more, {best} and {others[0]} least" if run.several else ""
    small = plan[0].lower() + plan[1:]
    return SAID[run.why].format(
        best=best, other="".join(others[:1]), plan=plan, small=small, least=least, sd=f"{run.separation_sd:.0f} sd"
    )


def plan_words(plan: Plan, rig: Rig) -> str:
    """A run FS (0 - 400 mm) at 20 m/min, 10 min of drive and 60 min of stop."""
    drive, stop = f"{plan.drive_s / 60:.0f} min", f"{plan.stop_s / 60:.0f} min"
    if plan.stroke_mm is None:
        on = " and ".join(
            f"{name} at {level:g} {rig.inputs[name].unit}".removesuffix(" 1") for name, level in plan.levels.items()
        )
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
