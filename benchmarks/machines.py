"""A model fitted to a machine of its own, machine after machine: how good, how sure, at what cost.

Every machine of the virtual rig runs the twelve experiments. The shipped model is fitted and tuned to some of them and
judged on the others, the truth unseen by fit and filter. Machines 1 - 20 are there to set things on; those that judge
have never set anything. Each machine leaves a line in a file, so that a study that was stopped goes on where it was.

python -m benchmarks machines [101-104] [three | runs] [quick]
    three  fitted to three runs instead of four;   runs: to one, two, four and eight;   quick: 15 channels only
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.accuracy import SITUATIONS
from benchmarks.judged import BLIND_MIN, FIRST, FITS, Case, asked, study
from benchmarks.kept import known, outcomes
from benchmarks.measure import Row, section, table

# band of each situation, um: of the median machine, of the worst
MOST_UM = dict(zip(SITUATIONS, [(0.35, 0.8), (0.6, 1.2), (0.6, None), (None, None), (1.0, None)]))
Found = dict[str, Any]  # what `study` returns
LINES = Path(__file__).parent / "machines.jsonl"


def measured(cases: Sequence[Case]) -> dict[Case, Found]:
    """Every case and what was found; what the file of lines holds, with all the situations, not again."""
    lines = [(Case(**case), out) for case, out in known(LINES)]
    found = {case: out for case in cases for line, out in lines if _covers(line, case)}
    return outcomes(LINES, cases, found, study, _told)


def _told(case: Case, out: Found) -> str:
    return f"machine {case.machine}, fitted to {case.fit}: {band(out, FIRST):.2f} um"


def _covers(line: Case, case: Case) -> bool:
    return (line.machine, line.fit) == (case.machine, case.fit) and set(line.situations) >= set(case.situations)


def markdown(*words: str) -> str:
    """Run all cases; the tables."""
    by_fit: dict[str, dict[int, Found]] = {}
    for case, outcome in measured(asked(words)).items():
        by_fit.setdefault(case.fit, {})[case.machine] = outcome
    if len(by_fit) > 1:
        return _by_runs(by_fit)
    return _section(FITS[case.fit], by_fit[case.fit])


def _section(fitted_on: Sequence[str], found: dict[int, Found]) -> str:
    """All tables of one choice of runs."""
    title = f"Machines: {len(found)} of them, model fitted to {', '.join(fitted_on)}, judged on their other runs"
    says = [
        "Reference minus estimate, the truth unseen by fit and filter. Blind: nothing is read from the middle of the "
        "first drive on, and again in the hour after the last stop; judged is the last tick."
    ]
    situations = [name for name in SITUATIONS if all(name in run for one in found.values() for run in _runs(one))]
    some = list(found.values())
    rows = [row for name in situations for row in (*_bands(some, name), *_sureness(some, name))]
    rows += [*_cooldown(some), *_blind(some), *_temperatures(some), *_fits(some)]
    return "\n".join([table(title, rows, says), _each(found, situations), _parameters(some)])


def _runs(one: Found) -> list[Any]:
    return list(one["runs"].values())


def _all(some: Sequence[Found], *path: str) -> list[Any]:
    """What stands at a path of every judged run of some machines."""
    found = [run for one in some for run in _runs(one)]
    for key in path:
        found = [each[key] for each in found]
    return found


def band(one: Found, situation: str) -> float:
    """Highest minus lowest error of a machine over its judged runs, um."""
    lowest, highest = np.transpose(_all([one], situation, "um"))
    return float(highest.max() - lowest.min())


def _spread(
    what: str, values: Sequence[float], most: tuple[float | None, float | None], form: str = ".2f"
) -> list[Row]:
    median, worst = float(np.median(values)), float(max(values))
    return [
        Row(f"{what}: median machine", f"{median:{form}}", median, most[0]),
        Row(f"{what}: worst machine", f"{worst:{form}}", worst, most[1]),
    ]


def _bands(some: Sequence[Found], situation: str) -> list[Row]:
    return _spread(f"{situation}: band, um", [band(one, situation) for one in some], MOST_UM[situation])


def _cooldown(some: Sequence[Found]) -> list[Row]:
    worst = [max(_all([one], FIRST, "cooldown_um")) for one in some]
    return _spread(f"{FIRST}: worst in the 60 min after stops, um", worst, (0.2, 0.5))


def _share(what: str, share: float, least: float = 0.90, most: float = 0.98) -> Row:
    return Row(what, f"{share:.1%}", share, least, True, most)


def _sureness(some: Sequence[Found], name: str) -> Iterator[Row]:
    """Does the truth lie where the filter says?"""
    inside, late, nees, ticks = (_all(some, name, key) for key in ("in_2sd", "cooldown_in_2sd", "nees", "ticks"))
    yield _share(f"{name}: truth in 2 sd, all ticks", float(np.average(inside, weights=ticks)), 0.92)
    yield Row(f"{name}: the same, run with the least", f"{min(inside):.1%}", min(inside), 0.75, True)
    yield _share(f"{name}: the same, in the hour after a stop", float(np.mean(late)))
    good = float(np.mean([0.3 <= each <= 2.5 for each in nees]))
    low, median, high = np.quantile(nees, [0.1, 0.5, 0.9])
    text = f"{good:.1%}; a tenth under {low:.2f}, median {median:.2f}, a tenth over {high:.2f}"
    yield Row(f"{name}: runs with a NEES of 0.3 .. 2.5", text, good, 0.9, True)


def _blind(some: Sequence[Found]) -> Iterator[Row]:
    for minutes in BLIND_MIN:
        off = np.abs(_all(some, "blind", f"{minutes} min"))
        yield _share(f"truth in 2 sd after {minutes} blind minutes", float((off <= 2.0).mean()))


def _temperatures(some: Sequence[Found]) -> Iterator[Row]:
    for phase in ("driving", "at rest"):
        inside = float(np.mean(_all(some, "temperatures", phase)))
        yield _share(f"true temperatures at the thermometers' places in 2 sd, {phase}", inside)


def _fits(some: Sequence[Found]) -> Iterator[Row]:
    converged = float(np.mean([one["converged"] for one in some]))
    yield Row("fits that converged", f"{converged:.1%}", converged, 0.95, True)
    inside = float(np.mean([abs(p["off"]) <= 2.0 for one in some for p in one["parameters"].values()]))
    yield _share("parameters within 2 sd of the machine's, where the laws are the same", inside)
    calm = float(np.mean([max(one["raised"].values()) <= 2.0 for one in some]))
    yield Row("process noise after `fit` at most twice that before", f"{calm:.1%} of machines", calm, 0.9, True)
    for key, named in (("places", "the screw's own process noise"), ("others", "process noise of heats and bodies")):
        yield from _spread(f"{named} after `tune` / before", [one["noise"][key] for one in some], (None, None))
    yield from _spread("fit, s of the processor", [one["fit_s"] for one in some], (40.0, None), ".0f")


def _each(found: dict[int, Found], situations: Sequence[str]) -> str:
    """A line a machine."""
    head = [*(f"band: {s}; in 2 sd" for s in situations), "60 min after stops", "noise: screw, others", "fit, s"]
    rows = [["machine", "laws of another form", *head]]
    for number, one in found.items():
        cells = [f"{band(one, s):.2f}; {np.mean(_all([one], s, 'in_2sd')):.0%}" for s in situations]
        cells += [
            f"{max(_all([one], FIRST, 'cooldown_um')):.2f}",
            ", ".join(f"{by:.2f}" for by in one["noise"].values()),
        ]
        ended = f"{one['fit_s']:.0f}{'' if one['converged'] else ', not converged'}"
        rows.append([str(number), ", ".join(one["laws"]), *cells, ended])
    return section("Machine by machine", rows, level=3)


def _parameters(some: Sequence[Found]) -> str:
    """A line a parameter: (fitted - true) / sd over the machines."""
    rows = [
        ["parameter", "machines", "within 2 sd", "off by sd, median", "worst", "fitted - true, median", "sd, median"]
    ]
    for path in dict.fromkeys(path for one in some for path in one["parameters"]):
        of = [one["parameters"][path] for one in some if path in one["parameters"]]
        off, apart, sd = np.array([[p["off"], p["value"] - p["true"], p["sd"]] for p in of]).T
        inside, worst = (np.abs(off) <= 2.0).mean(), off[np.argmax(np.abs(off))]
        cells = [f"{inside:.0%}", f"{np.median(off):+.2f}", f"{worst:+.1f}"]
        rows.append([path, str(len(of)), *cells, f"{np.median(apart):+.3g}", f"{np.median(sd):.3g}"])
    return section("Parameters against the machines'", rows, level=3)


def _by_runs(by_fit: dict[str, dict[int, Found]]) -> str:
    """How good with how many runs fitted, on runs that none of the fits has seen."""
    shared = set.intersection(*({run for one in found.values() for run in one["runs"]} for found in by_fit.values()))
    rows = [["fitted to", "band, um, median machine", "worst", "60 min after stops", "in 2 sd", "fit, s"]]
    for name, found in by_fit.items():
        some = [one | {"runs": {run: one["runs"][run] for run in shared}} for one in found.values()]
        bands, late = [band(one, FIRST) for one in some], [max(_all([one], FIRST, "cooldown_um")) for one in some]
        seconds = np.median([one["fit_s"] for one in some])
        cells = [f"{np.median(bands):.2f}", f"{max(bands):.2f}", f"{np.median(late):.2f}"]
        rows.append([name, *cells, f"{np.mean(_all(some, FIRST, 'in_2sd')):.1%}", f"{seconds:.0f}"])
    title = f"Machines {', '.join(map(str, found))}, by the runs fitted to; {FIRST}"
    return section(title, rows, [f"Judged on {', '.join(sorted(shared))}, which none of the fits has seen."])
