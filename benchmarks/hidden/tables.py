"""The tables of the study: every row with what must come out, what was said to what, and every case that came out
wrong."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping

import numpy as np
from scipy.stats import beta

from benchmarks.hidden.cases import DEV, FAR, JUDGING, ROADS, ROWS, Case, asked
from benchmarks.hidden.judge import confused, costly, follows_drawn, gained, is_named, right
from benchmarks.hidden.lines import outcomes
from benchmarks.hidden.outcome import NAMING, Outcome
from benchmarks.hidden.study import IMPROVED
from benchmarks.measure import section

Outcomes = Mapping[Case, Outcome]
BY_ROAD = {"healthy": ">= 95 %", "same": ">= 90 %", "shipped": ">= 85 %"}  # of the row "one"
CAME = {
    "healthy": "fitted to this machine's healthy runs",
    "same": "fitted to the same recordings",
    "shipped": "the shipped one, another machine's",
}
TITLES = {
    "half": ("one effect, half as strong", ""),
    "double": ("one effect, twice as strong", ""),
    "none": ('nothing planted: "nothing missing", or what is another on this machine', ">= 95 %"),
    "two": ("two effects: both found by improve", ">= 85 %"),
    "three": ("three effects: two at least found by improve", ">= 80 %"),
    "stranger": ("in no catalogue: said so, within 60 mm, right input", ">= 90 %"),
    "drawn": ("heat of a drawn place, length and law: composed, within 60 mm", ">= 90 %"),
    "bare": ("one heat effect, the catalogue taken away: half of its gain by what is composed", ""),
    "reading": ("a reading wrong by a drawn law: composed, right channel, follower right or tied", ">= 85 %"),
    "event": ("an event within one run: told by diagnose or suggest, within 10 min", ">= 90 %"),
    "label": ("a wrong input of one run of six: run and signal named", ">= 95 %"),
    "sensor": ("a thermometer that fails in one run: named, and no heat", ">= 95 %"),
    "shifted": ("the position 40 mm off in all runs: named", ""),
}


def markdown(*words: str) -> str:
    """Run the cases that words ask for; the tables."""
    of = outcomes(asked(words), 1 if "alone" in words else None)
    return "\n".join([_musts(of, "dev" in words), _roads(of), *_said(of), _wrong(of)])


def interval(good: int, n: int) -> str:
    """Share in % with its 95 % interval (Clopper and Pearson 1934)."""
    if not n:
        return "-"
    lo = beta.ppf(0.025, good, n - good + 1) if good else 0.0
    hi = beta.ppf(0.975, good + 1, n - good) if good < n else 1.0
    return f"{good} of {n}: {good / n:.0%} ({lo:.0%} - {hi:.0%})"


def share(of: Outcomes, good: Callable[[Case, Outcome], bool] = right) -> str:
    """Of how many cases something is so."""
    return interval(sum(good(*each) for each in of.items()), len(of))


def some(of: Outcomes, *rows: str, road: str = "") -> Outcomes:
    """The cases of some rows, of one road if it is named."""
    return {case: out for case, out in of.items() if case.row in rows and road in ("", case.road)}


def _musts(of: Outcomes, dev: bool) -> str:
    rows = [["", "measured", "must be"]]
    for road, must in BY_ROAD.items():
        rows.append(
            [f"one effect, model {CAME[road]}: first, or in a tie of three", share(some(of, "one", road=road)), must]
        )
    rows += [[title, share(some(of, row)), must] for row, (title, must) in TITLES.items()]
    rows += [
        *_composed(of),
        *_false(of),
        *_ties(some(of, "one")),
        *_held_out(some(of, "two", "three")),
        *_seconds(of),
    ]
    machines = f"1 - {DEV}" if dev else f"{JUDGING} - {JUDGING + FAR * len(ROADS) - 1}"
    says = [f"Machines out of {machines}, another in every case of a row; shares with 95 % interval."]
    return section("Which effect is missing, machine by machine", [row for row in rows if row[1] != "-"], says)


def _false(of: Outcomes) -> Iterator[list[str]]:
    nothing, large = some(of, "none"), {case: out for case, out in some(of, "one").items() if costly(out)}
    yield [
        "  an effect named that is not there",
        share(nothing, lambda c, o: bool(o.said) and not right(c, o)),
        "<= 5 %",
    ]
    yield ["  a time told at which nothing began", share(nothing, lambda c, o: bool(o.began)), ""]
    yield ["heat taken for a reading or the reverse, one effect, above 1 um", share(large, confused), "<= 2 %"]


def _composed(of: Outcomes) -> Iterator[list[str]]:
    drawn, nothing = some(of, "drawn"), some(of, "none")
    yield ["  it follows what it should, or that as well", share(drawn, follows_drawn), ">= 80 %"]
    ratios = [out.after[i] / out.knowing[i] for out in drawn.values() if out.after and out.knowing for i in (0, 1)]
    if ratios:
        told = f"{np.median(ratios):.2f}; {interval(sum(r < 2.0 for r in ratios), len(ratios))}"
        yield ["  held-out error, of a model with the true law: median; below 2", told, "<= 1.3; >= 85 %"]
        worse = sum(a > b for out in drawn.values() if out.composed for a, b in zip(out.after, out.before))
        yield ["  held-out error above the one before, of temperature or elongation", str(worse), "0"]
    shares = [share for out in some(of, "bare").values() for share in gained(out)]
    if shares:
        yield ["  share of the gain of the true effect, held out: median", f"{np.median(shares):.0%}", ">= 80 %"]
    yield ["  something composed where nothing is planted", share(nothing, lambda c, o: bool(o.composed)), "<= 5 %"]


def _ties(one: Outcomes) -> Iterator[list[str]]:
    ties = {case: out for case, out in one.items() if out.verdict == "tie"}
    yield ["ties, one effect", share(one, lambda case, out: out.verdict == "tie"), "<= 20 %"]
    yield ["  the true one in it", share(ties, lambda case, out: is_named(case, out, case.hidden.names[0])), ">= 95 %"]


def _held_out(improved: Outcomes) -> Iterator[list[str]]:
    """Errors after improve, of temperature and of elongation alike."""
    for what, than, must in (
        ("the model that knows", "knowing", ("<= 1.05", "<= 1.3")),
        ("the one before", "before", ("", "<= 1")),
    ):
        ratios = [a / b for out in improved.values() for a, b in zip(out.after, getattr(out, than))]
        told = f"{np.median(ratios):.2f}, {max(ratios):.2f}" if ratios else "-"
        yield [f"held-out error after improve / of {what}: median, worst", told, ", ".join(filter(None, must))]


def _seconds(of: Outcomes) -> Iterator[list[str]]:
    for what, rows, must in (
        ("suggest, four runs", [row for row in ROWS if row not in (*IMPROVED, "label")], ""),
        ("suggest, six runs", ["label"], "<= 33"),
        ("improve, two effects", ["two"], "<= 160"),
    ):
        took = [out.search_s for out in some(of, *rows).values() if not out.error]
        yield [f"{what}: s of the processor, median", f"{np.median(took):.0f}" if took else "-", must]
    yield ["a case, runs and fits too: s, median", f"{np.median([out.seconds for out in of.values()]):.0f}", ""]


def _roads(of: Outcomes) -> str:
    """Every row by the road the model came."""
    rows = [[row, *(share(some(of, row, road=road)) for road in ROADS)] for row in ROWS if some(of, row)]
    return section("By the model's road", [["", *ROADS], *rows], level=3)


def _said(of: Outcomes) -> Iterator[str]:
    """What was hidden, and what was said, road by road."""
    for road in ROADS:
        counts: dict[str, Counter[str]] = {}
        for case, out in some(of, "one", "none", "stranger", "drawn", road=road).items():
            counts.setdefault(" + ".join(case.hidden.names) or "nothing", Counter())[_words(out)] += 1
        rows = [[name, ", ".join(f"{n} x {said}" for said, n in each.most_common())] for name, each in counts.items()]
        if rows:
            yield section(
                f"What was hidden, and what was said: model {CAME[road]}", [["hidden", "said"], *rows], level=3
            )


def _words(out: Outcome) -> str:
    link = " or " if out.verdict == "tie" else " + "
    return "an error" if out.error else link.join(out.said) if out.verdict in NAMING else out.verdict


def _wrong(of: Outcomes) -> str:
    """Every case that came out wrong, by the words that do it again."""
    rows = [["case", "machine", "hidden", "verdict", "named", "where, or what was raised"]]
    for case, out in of.items():
        if not right(case, out):
            at = f"{out.place_mm:.0f} mm" if out.place_mm is not None else out.channel
            named = " ".join([*out.said, *out.wrong])
            hidden = " + ".join(case.hidden.names) or "-"
            rows.append(
                [str(case), str(case.machine), hidden, out.verdict, named, out.error or f"{at} {out.follows}".strip()]
            )
    return section("Cases that came out wrong", rows, level=3)
