"""A trend: what has changed since when, every parameter's course as a row, and JSON."""

from collections.abc import Iterator
from datetime import datetime
from typing import Any

import numpy as np

from ballscrew.terminal import Terminal
from estimator.trend.course import Course
from estimator.trend.drift import FEWEST, WEEK_S
from estimator.trend.trend import Told, Trend

HEAD = ["parameter", "unit", "runs", "mean", "scatter", "sd of a run", "first", "last", "change"]


def print_trend(terminal: Terminal, trend: Trend) -> None:
    """The parameters that runs tell of, and what a maintenance engineer should know of them."""
    known = [course for course in trend.courses if len(course.known)]
    terminal.table([HEAD, *(_row(course, trend) for course in known)])
    silent = [course.name for course in trend.courses if not len(course.known)]
    if silent:
        terminal.say(f"\nof these a single run tells no more than its table: {', '.join(silent)}")
    terminal.say()
    for sentence in sentences(trend):
        terminal.say(sentence)


def _row(course: Course, trend: Trend) -> list[str]:
    value, sd = course.value[course.known], course.sd[course.known]
    digits = max(0, 1 - int(np.floor(np.log10(np.median(sd)))))
    numbers = [value.mean(), value.std(), float(np.median(sd)), value[0], value[-1]]
    told = next((one.drift for one in trend.told if one.drift.course.name == course.name), None)
    change = f"{told.share:+.1%}" if told else ""
    return [course.name, course.unit, str(len(value)), *(f"{x:.{digits}f}" for x in numbers), change]


def sentences(trend: Trend) -> list[str]:
    """What has changed, the clearest first; else that nothing has."""
    if trend.told:
        return [*_order(trend), *(_sentence(one, trend) for one in trend.told)]
    known, runs = sum(len(course.known) >= FEWEST for course in trend.courses), f"these {len(trend.names)} runs"
    if not known:
        return [*_order(trend), f"Whether a parameter has changed {runs} do not tell: of none do {FEWEST} know enough."]
    of = f"of the {len(trend.courses)} that the model leaves open"
    if not trend.tellable:
        return [*_order(trend), f"{runs.capitalize()} are too few to tell that one {of} has changed, however much."]
    none = f"No parameter has changed over {runs} by more than chance gives: {of}, {known} are told by single runs."
    few = "A step so few runs do not tell, however large: a rise only."
    return [*_order(trend), none, *([] if "step" in trend.tellable else [few])]


def _order(trend: Trend) -> Iterator[str]:
    """What is odd of the runs' dates."""
    alone = trend.undated if len(trend.undated) < len(trend.names) else ()
    if trend.dated:
        _, first, count = np.unique(trend.start_s, return_index=True, return_counts=True)
        for i, n in zip(first[count > 1], count[count > 1], strict=True):
            same = ", ".join(trend.names[i : i + n])
            yield f"{same} begin at one instant, {_date(trend, i)}: look for a clock that stands, or copies of one run."
    elif alone:
        more = "tells" if len(alone) == 1 else "tell"
        yield f"{', '.join(alone)} {more} no date: all are taken in the order given; without, they are by their dates."
    else:
        of = "tell no date" if trend.undated else "all begin at one date"
        yield f"These recordings {of}: they are taken in the order given."


def _sentence(told: Told, trend: Trend) -> str:
    """friction of the anchor bearing: 12.9 % more (7 sd) since 3 November, 4.1 % a week."""
    one = told.drift
    course, size = one.course, f"{abs(one.share):.1%}" if np.isfinite(one.share) else f"{abs(one.change):.3g}"
    unit = "" if course.unit == "1" else f" {course.unit}"
    of = "" if "." in course.name else " of what the model says"
    ends = f"from {one.before:.3g} to {one.before + one.change:.3g}{unit}{of}"
    sure = f"{abs(one.change) / one.sd:.0f} sd; p {max(one.p, 0.001):.3f} of all parameters"
    if one.shape == "step":
        how = f"has become {size} {'larger' if one.change > 0 else 'smaller'} with {_when(trend, one.run)}"
    else:
        rate = per_week(told, trend)
        weekly = f", {abs(rate[0] / one.before):.1%} a week" if rate and one.before else ""
        how = f"has {'risen' if one.change > 0 else 'fallen'} by {size} since {_when(trend, one.run - 1)}{weekly}"
    besides = f"; or as well {', '.join(told.or_else)}" if told.or_else else ""
    name = course.name if "." in course.name else f"{course.name}, all its powers together,"
    return f"{name} {how}, {ends} ({sure}){besides}."


def _when(trend: Trend, run: int) -> str:
    name = trend.names[run]
    return f"{_date(trend, run)} ({name})" if trend.dated else name


def _date(trend: Trend, run: int) -> str:
    return datetime.fromtimestamp(trend.start_s[run]).isoformat(" ", "minutes")


def per_week(told: Told, trend: Trend) -> tuple[float, float] | None:
    """Of a rise, in the parameter's unit, with its sd; of a step over all runs; None where the runs have no dates."""
    one = told.drift
    began = trend.start_s[one.run - 1] if one.shape == "rise" else trend.start_s[0]
    weeks = (trend.start_s[-1] - began) / WEEK_S
    return (one.change / weeks, one.sd / weeks) if trend.dated else None


def as_json(trend: Trend) -> dict[str, Any]:
    """The trend for programs."""
    return {
        "parameters": {course.name: list(_values(course, trend)) for course in trend.courses},
        "drifts": [_drift(one, trend) for one in trend.told],
        "sentences": sentences(trend),
    }


def _values(course: Course, trend: Trend) -> Iterator[dict[str, object]]:
    for i in course.known.tolist():
        start = _date(trend, i) if trend.dated else None
        yield {"recording": trend.names[i], "start": start, "value": course.value[i], "sd": course.sd[i]}


def _drift(told: Told, trend: Trend) -> dict[str, object]:
    one, rate = told.drift, per_week(told, trend) or (None, None)
    first = one.run if one.shape == "step" else one.run - 1
    return {
        "parameter": one.course.name, "unit": one.course.unit, "per_week": rate[0], "sd": rate[1],
        "since": _date(trend, first) if trend.dated else trend.names[first], "recording": trend.names[first],
        "p": one.p, "shape": one.shape, "before": one.before, "change": one.change, "change_sd": one.sd,
        "or_else": list(told.or_else),
    }  # fmt: skip
