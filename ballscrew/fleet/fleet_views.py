"""A plant as views: what each rig's recordings say over weeks."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ballscrew.fleet.fleet_report import sections
from ballscrew.fleet.inspection import Inspection
from ballscrew.report.sections import markdown
from estimator.errors import InputError
from viz.plant.plant import Figure, RigOverTime, save

FIGURES = (
    Figure("Error", "rms of reference − filter [µm]", "µm"),
    Figure("NIS", "NIS in doublings: 0 where the noise is right", "", signed=True),
    Figure("Model alone", "rms of thermometer − model alone [K]", "K"),
)


def save_views(path: Path, found: Sequence[Inspection]) -> None:
    """Write what was found into `path`; an InputError where no rig has a recording that could be used."""
    if not any(one.runs for one in found):
        raise InputError(f"{path}: not written: no rig has a recording that could be used")
    dated = all(run.began_s is not None for one in found for run in one.runs)
    rigs = [_over_time(one, name, dated) for one, name in zip(found, _names(found), strict=True)]
    save(path, rigs, FIGURES, dated, markdown(sections(found)))


def _over_time(one: Inspection, name: str, dated: bool) -> RigOverTime:
    runs = sorted(one.runs, key=lambda run: run.began_s or 0.0) if dated else one.runs
    begun_s = np.array([run.began_s for run in runs], dtype=float) if dated else 1.0 + np.arange(len(runs))
    values = np.array([(run.filter_um, np.log2(run.nis), run.alone_K) for run in runs]).reshape(-1, len(FIGURES))
    return RigOverTime(f"{name}{_how(one)}", begun_s, values)


def _names(found: Sequence[Inspection]) -> list[str]:
    """Of the folders, without where they are, if that leaves each its own."""
    names = [Path(one.folder).resolve().name for one in found]
    return names if len({*names}) == len(names) else [one.folder for one in found]


def _how(one: Inspection) -> str:
    """What its row says beside its name."""
    if one.error:
        return ": failed"
    said = [*([] if one.adequate else ["model fails"]), *(["drifts"] if one.drifts else [])]
    return f": {', '.join(said)}" if said else ""
