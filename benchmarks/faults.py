"""One bad thermometer never becomes an estimate: recordings with failures put in, and healthy ones in which none is.

An error is measured against the same run with the failing channels muted from then on: what the failure has added. Each
case leaves a line in a file, so that a study that was stopped goes on where it was. Thresholds of the judge were set on
rigs of seeds 101 to 103 and machines 1 to 8; none of those judges here.

python -m benchmarks faults [ROW ...]    some of the rows without a failure only, printed and not kept
python -m benchmarks faults drifts       slow drifts one by one, likewise
python -m benchmarks faults lies         a displacement, a position or a speed that lies
python -m benchmarks faults alike        heat that the model lacks, and two neighbours that drift alike
python -m benchmarks faults silences     the telemeter silent for minutes, on machines that are not the model's
"""

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np

from benchmarks import alike, drifts, handed_over, lies, paper_rig, silences, sound
from benchmarks.drifts import LOST_SD, LOST_UM, longest
from benchmarks.failed import SEED, WHEN, Case, Outcome, by_kind, cells, named, share
from benchmarks.injected import FAILURES, INPUT_FAILURES, NAMED, failing, failing_input, shifted
from benchmarks.kept import known, outcomes
from benchmarks.measure import Row, table
from estimator.batch.replay import replay
from estimator.faults.fault import Fault
from estimator.inputs.gate import SLOW
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.step import Track

LINES = Path(__file__).parent / "faults.jsonl"
RUNS = ("FS-20", "FS-10", "FS-5", "FS-2.5", "CS-20", "CS-10", "CS-5", "CS-2.5", "ES-20", "ES-10", "ES-5", "ES-2.5")
SEVEN = "seven channels, "
ASIDE: dict[str, Callable[[], str]] = {  # tables of their own
    "drifts": lambda: drifts.table(WHEN, SEED),
    "lies": lies.table,
    "alike": lambda: alike.table(WHEN, SEED),
    "silences": lambda: silences.table(SEED),
}
FROM_THE_START = ("0 degC", "85 degC")  # what else an input does from the start on is its zero
LATE = (
    "A drift of 3 K/h is 0.05 K after 60 s: 5.6 sd of a slope fitted to readings that scatter by 0.02 K, "
    "were the model exact and the beginning known. The judge accuses from 7 sd on, or healthy ones would "
    "be accused; from 4 sd on it says that a thermometer may drift, and uses it. That counts as named, of a drift "
    "and of two that are swapped; healthy ones that are suspected so are counted in rows of their own. "
    "Spikes are named when the second ends, which in four of thirty cells comes after 60 s. "
    "Two that are equally warm when they are swapped read right until they part."
)
NOT_PHYSICAL = ("sd", "noise", "zero_sd", "zero_walk", "lag_noise")


def cases() -> Iterator[Case]:
    """All cases, those that count most first."""
    rig = paper_rig.rig()
    heat = np.flatnonzero(rig.is_thermometer).tolist()
    seven = [rig.index(name) for name in rig.subset_7]
    for seven_only, channels in (("", heat), (SEVEN, seven)):
        for when, (run, at_s) in WHEN.items():
            for n, i in enumerate(channels):  # one after the other: they are held against the same muted run
                for kind in (*FAILURES, "swapped"):
                    both = (i, channels[(n + len(channels) // 3) % len(channels)]) if kind == "swapped" else (i,)
                    yield Case(f"{seven_only}{when}", run, at_s, kind, both, SEED)
    for name in SLOW:
        for at_s in (0.0, *(at_s for _, at_s in WHEN.values())):
            for kind in INPUT_FAILURES:
                if at_s or kind in FROM_THE_START:
                    yield Case("inputs", "FS-20", at_s, f"{name}: {kind}", (), SEED)
    for run in RUNS:
        for seed in range(SEED, SEED + 3):
            yield Case("healthy", run, 0.0, "", (), seed)
            yield Case("wrong model", run, 0.0, "", (), seed)
        for number in sound.OTHERS:
            yield Case("another machine", run, 0.0, "", (), number)
    for n in range(20):
        dice = np.random.default_rng(n)
        kind, pair = list(FAILURES)[n % len(FAILURES)], sorted(dice.choice(heat, 2, replace=False).tolist())
        run, at_s = list(WHEN.values())[n % 2]
        yield Case("two at once", run, at_s, kind, tuple(pair), SEED)
        yield Case("all zeros", run, at_s, ("board", "each")[n // 2 % 2], tuple(heat), SEED + n)


@lru_cache(maxsize=2)
def simulated(run: str, seed: int, machine: int = 0) -> tuple[Recording, Array]:
    """A run of the rig as ticks, and the elongation that is true at each."""
    return handed_over.simulated(run, paper_rig.rig(), machine=machine, seed=seed)


@lru_cache(maxsize=4)
def without(run: str, seed: int, at_s: float, channels: tuple[int, ...]) -> Track:
    """The run with channels muted from a time on."""
    rig, silent = paper_rig.rig(), np.zeros(len(paper_rig.rig().names), dtype=bool)
    silent[list(channels)] = True
    return replay(paper_rig.model(), rig, simulated(run, seed)[0], lambda t: silent & (t >= at_s))


def wrong(model: Model, seed: int) -> Model:
    """A model of which every physical parameter is off."""
    dice, values = np.random.default_rng(seed), {}
    for path in model.values:
        if path.partition(".")[2] not in NOT_PHYSICAL and isinstance(model[path], float) and model[path] > 0.0:
            param, factor = model.param(path), (1.0 + sound.WRONG) ** dice.choice([-1.0, 1.0])
            values[path] = float(np.clip(model[path] * factor, param.lo, param.hi))
    return model.with_values(values)


def study(case: Case) -> Outcome:
    """One case."""
    rig, model = paper_rig.rig(), paper_rig.model()
    recording, true_um = simulated(case.run, case.seed, case.seed if case.row == "another machine" else 0)
    if case.row == "inputs":
        name, _, kind = case.kind.partition(": ")
        track = replay(model, rig, failing_input(recording, name, kind, case.at_s))
        return _outcome(case, rig, track, without(case.run, case.seed, 0.0, ()), true_um)
    if not case.channels:
        track = replay(wrong(model, case.seed) if case.row == "wrong model" else model, rig, recording)
        return _outcome(case, rig, track, track, true_um)
    missing = tuple(np.flatnonzero(_left_out(case, rig)).tolist())
    recording = _with(recording, rig, case)
    base = without(case.run, case.seed, case.at_s, case.channels if case.row != "all zeros" else ())
    if missing:
        silent = _left_out(case, rig)
        base = replay(model, rig, recording, lambda t: silent | (_of(case.channels, rig) & (t >= case.at_s)))
        return _outcome(case, rig, replay(model, rig, recording, lambda t: silent), base, true_um)
    return _outcome(case, rig, replay(model, rig, recording), base, true_um)


def _with(recording: Recording, rig: Rig, case: Case) -> Recording:
    """The recording with the failure of the case."""
    if case.row != "all zeros":
        return failing(recording, case.kind, case.channels, case.at_s, case.seed + case.channels[0])
    dice = np.random.default_rng(case.seed)
    size = (
        1.0 if case.kind == "board" else dice.uniform(0.3, 2.0, len(rig.names)) * dice.choice([-1, 1], len(rig.names))
    )
    return shifted(recording, np.where(rig.is_thermometer, size, 0.0), case.at_s)


def _of(channels: Sequence[int], rig: Rig) -> Array:
    return np.isin(np.arange(len(rig.names)), channels)


def _left_out(case: Case, rig: Rig) -> Array:
    """Channels that the run does without from the start on, (m,) bool."""
    seven = np.isin(rig.names, rig.subset_7) | ~rig.is_thermometer
    return ~seven if case.row.startswith(SEVEN) else np.zeros(len(seven), dtype=bool)


def _outcome(case: Case, rig: Rig, track: Track, base: Track, true_um: Array) -> Outcome:
    now = np.isfinite(track.elongation_um) & np.isfinite(base.elongation_um) & (track.time_s >= case.at_s)
    error, sd = np.abs(true_um - track.elongation_um)[now], track.sigma_um[now]
    added = np.abs(track.elongation_um - base.elongation_um)[now]
    fault, tick_s = track.fault[now], rig.tick_s
    own = _of(case.channels, rig) if case.row != "all zeros" else np.zeros(len(rig.names), dtype=bool)
    healthy = rig.is_thermometer & ~own
    words = NAMED.get(case.kind, ())
    may_drift = (track.may_drift_K[now] != 0) & track.fused[now]
    right = np.isin(fault, [each for each in Fault if each.word in words])
    right |= may_drift & (track.since_s[now] >= case.at_s) & (Fault.DRIFTING.word in words)
    named = [np.flatnonzero(right[:, i]) for i in np.flatnonzero(own)]
    if case.row == "all zeros":
        named = [np.flatnonzero((track.jump[now] != 0.0).sum(axis=1) > len(rig.thermometers) // 2)]
    named_s = max((float(rows[0]) * tick_s if len(rows) else np.inf for rows in named), default=0.0)
    return Outcome(
        um=float(added.max()),
        in_2sd=float((error <= 2.0 * sd).mean()),
        named_s=named_s,
        accused=int((fault[:, healthy] > Fault.JUDGED).any(axis=0).sum()) + bool(track.shift_mm[now].any()),
        suspected=int(may_drift[:, healthy].any(axis=0).sum()),
        suspected_share=float(may_drift[:, healthy].mean()),
        sd_um=float(sd.mean()),
        lost_s=longest(error > np.maximum(LOST_SD * sd, LOST_UM)) * tick_s,
        band_um=float(np.ptp(error)),
    )


def measured(some: Sequence[Case]) -> dict[Case, Outcome]:
    """Some cases and their outcomes, those of the file of lines not again."""
    found = {Case(**case | {"channels": tuple(case["channels"])}): Outcome(**out) for case, out in known(LINES)}
    return outcomes(LINES, some, found, study, _told, len(FAILURES) + 1)


def _told(case: Case, out: Outcome) -> str:
    return f"{case.row}, {case.kind}, {case.run}: {out.um:.2f} um"


def markdown(*names: str) -> str:
    """Run all cases, or some rows of those without a failure, or slow drifts; the table."""
    if len(names) == 1 and names[0] in ASIDE:
        return ASIDE[names[0]]()
    if unknown := set(names) - set(sound.ROWS):
        raise SystemExit(f"faults: what is {', '.join(unknown)}? Rows are {', '.join((*sound.ROWS, *ASIDE))}")
    found = measured([case for case in cases() if not names or case.row in names])
    return sound.tables({name: _row(found, name) for name in sound.ROWS}) if names else _all(found)


def _all(found: dict[Case, Outcome]) -> str:
    """The tables of all cases."""
    rows = [row for when in WHEN for row in cells(found, when, (0.95, 0.1))]
    rows += [row for when in WHEN for row in cells(found, SEVEN + when, (0.95, 0.5))]
    for name in ("two at once", "all zeros", "inputs"):
        some = [outcome for case, outcome in found.items() if case.row == name]
        rows.append(Row(f"{name}: share of cases with <= 0.5 um", *share([o.um <= 0.5 for o in some]), 1.0, True))
        rows.append(Row(f"{name}: largest, um", f"{max(o.um for o in some):.2f}"))
        rows.append(Row(f"{name}: channels or inputs accused that were well", str(sum(o.accused for o in some))))
        if name != "inputs":
            rows.append(named(name, some))
    says = [f"Runs of {', '.join(run for run, _ in WHEN.values())} with a failure at {SEED} and later seeds. {LATE}"]
    tables = [
        table("Thermometers that fail", rows, says),
        sound.tables({name: _row(found, name) for name in sound.ROWS}),
        *by_kind(found),
    ]
    return "\n".join([*tables, *(aside() for aside in ASIDE.values())])


def _row(found: dict[Case, Outcome], row: str) -> list[Outcome]:
    return [outcome for case, outcome in found.items() if case.row == row]
