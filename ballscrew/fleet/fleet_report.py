"""A plant as a table, a row a rig, and as JSON."""

from collections.abc import Iterator, Sequence

import numpy as np

from ballscrew.fleet.inspection import Inspection
from ballscrew.report.sections import Section, number
from ballscrew.terminal import Terminal

HEAD = ["rig", "runs", "band, um", "in 2 sd", "NIS", "model", "drifts"]
JSON = ("folder", "recordings", "failed", "filter", "nis", "adequate", "verdict", "where", "drifts", "error")


def print_fleet(terminal: Terminal, found: Sequence[Inspection]) -> None:
    """The table, and below it what a person should know of each rig that is not well."""
    plant, *rigs = sections(found)
    terminal.table(plant.rows, prose=6)
    for section in rigs:
        terminal.say("\n" + "\n".join([f"{section.title}:", *section.said]))


def sections(found: Sequence[Inspection]) -> list[Section]:
    """The table, and what is to be said of each rig that is not well."""
    said = {
        one.folder: [one.error] if one.error else [*_lost(one), *(one.said if not _well(one) else ())] for one in found
    }
    return [Section("Plant", rows=[HEAD, *map(_row, found)]), *(Section(*each) for each in said.items() if each[1])]


def _row(one: Inspection) -> list[str]:
    if one.error:
        return [one.folder, "", "", "", "", "failed", ""]
    low, high = one.filter["band_um"] if one.filter else (np.nan, np.nan)
    covered = one.filter["coverage_2sigma"] if one.filter else np.nan
    percent = f"{covered:.1%}" if np.isfinite(covered) else ""
    model = one.verdict or ("adequate" if one.adequate else "fails")
    drifts = ", ".join(str(drift["parameter"]) for drift in one.drifts or ())
    return [one.folder, str(one.recordings), number(high - low), percent, number(one.nis), model, drifts]


def _well(one: Inspection) -> bool:
    return bool(one.adequate) and not one.drifts


def _lost(one: Inspection) -> Iterator[str]:
    for failed in one.failed:
        yield f"not used: {failed}"


def as_json(found: Sequence[Inspection]) -> dict[str, object]:
    """The plant for programs."""
    return {"rigs": [{key: getattr(one, key) for key in JSON} for one in found]}
