"""A fit of ten parameters to four recordings, in one process and in two."""

from collections.abc import Sequence
from dataclasses import replace

from ballscrew.workers.processes import working
from benchmarks import paper_rig
from benchmarks.measure import Row, say, table, timed
from estimator.fit.fit import Fit, fit
from estimator.model import Model, Value
from estimator.work import Runs

RUNS = ("FS-20", "FS-5", "CS-10", "ES-2.5")
TEN = (
    "still_air.h", "rotating_convection.h", "nut_friction.power", "nut_friction.power_nut", "nut_body.g",
    "anchor_friction.power", "anchor_housing.g", "free_friction.power", "free_housing.g", "thermometers.tau",
)  # fmt: skip
SAYS = (
    "All of `estimator.fit.fit.fit`: the judging of readings, least squares open loop, the check of the process noise. "
    "Begun from the catalogue's defaults, every other parameter fixed as shipped."
)


def only(model: Model, paths: Sequence[str]) -> Model:
    """The model with these parameters free, at the catalogue's defaults, and all others fixed as they are."""
    fixed = {path: replace(value, fixed=True) for path, value in model.values.items()}
    return model.with_values(fixed | {path: Value(model.param(path).value) for path in paths})


def markdown() -> str:
    """Seconds of both, and how the search ended."""
    rig, model = paper_rig.rig(), only(paper_rig.model(), TEN)
    runs = Runs(rig, [paper_rig.recording(name) for name in RUNS])
    say("  fit")
    found, cpu, wall = timed(lambda: fit(model, runs))
    say("  fit in two processes")
    with working(2) as workers:
        _, _, shared = timed(lambda: fit(model, replace(runs, workers=workers)))
    ticks = sum(map(len, runs.recordings))
    title = f"Engine: fit of {len(TEN)} parameters to {', '.join(RUNS)}, {ticks} ticks"
    return table(title, _rows(found, cpu, wall, shared), [SAYS])


def _rows(found: Fit, cpu: float, wall: float, shared: float) -> list[Row]:
    ending, ratio = "converged" if found.converged else "not converged", wall / shared
    return [
        Row("fit, one thread", f"{wall:.1f} s on the clock, {cpu:.1f} s CPU", wall, 15.0),
        Row("fit, two processes, one / two on the clock", f"{shared:.1f} s, {ratio:.2f}", ratio, 1.7, least=True),
        Row("its search", f"{found.steps} open-loop runs, {ending}, process noise x {found.raised.others:.2f}"),
    ]
