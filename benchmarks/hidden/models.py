"""The model that a user comes with, by each of the roads."""

import hashlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from benchmarks import paper_rig
from benchmarks.handed_over import simulated
from benchmarks.hidden.cases import Case
from benchmarks.judged import FITS
from benchmarks.machine_truth import FIRST_SEED, KEPT
from estimator.fit.fit import fit
from estimator.model import Model
from estimator.record import Recording
from estimator.rig import Rig
from estimator.rig_folder.model_toml import load_model, save_model
from estimator.work import Runs

ROOT = Path(__file__).parents[2]
SHIPPED = ("base", "model")
SEARCHES = ("hypotheses", "missing_effect", "missing_heat", "events")  # which no fit rests on


def model_of(case: Case, rig: Rig, seen: Sequence[Recording]) -> Model:
    """The model of a case, without what is taken out of it; on the road `same` it is fitted without that."""
    if case.road == "healthy":
        return _without(healthy_model(case.machine, rig), case)
    if case.road == "same":
        return fit(_without(paper_rig.model(), case), Runs(rig, seen)).model
    return _without(paper_rig.model(SHIPPED[case.drawn("model", len(SHIPPED))]), case)


def _without(model: Model, case: Case) -> Model:
    for name in case.hidden.taken:
        model = model - name
    return model


def healthy_model(number: int, rig: Rig) -> Model:
    """The shipped model fitted to four healthy runs of a machine; kept as long as fit and rig in software are the
    same."""
    file = KEPT / _basis() / f"{number}.toml"
    if not file.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        healthy = [simulated(name, rig, number, FIRST_SEED + number)[0] for name in FITS["four"]]
        made = file.with_name(f"{number}-{id(healthy)}.part")
        save_model(fit(paper_rig.model(), Runs(rig, healthy)).model, made)
        made.replace(file)
    return load_model(file)


@cache
def _basis() -> str:
    """Short hash of all that a fit to the virtual rig rests on."""
    code = [file for top in ("estimator", "drivers") for file in sorted((ROOT / top).rglob("*.py"))]
    rests = [file for file in code if file.parent.name not in SEARCHES]
    files = [*rests, *(paper_rig.FOLDER / name for name in ("rig.toml", "model.toml"))]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:12]
