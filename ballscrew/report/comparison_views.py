"""What the views of one or two models show: the filter and the model alone on each recording, and the heat missing."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ballscrew.report.felt_report import WAYS, AtTheTable, most
from ballscrew.report.sections import Section, markdown
from ballscrew.workers.processes import working
from ballscrew.workspace import Loaded, Workspace
from estimator.accuracy.noise_floor import Error
from estimator.accuracy.reference import readings
from estimator.batch.replay import replay
from estimator.batch.trials import slow_trials_of
from estimator.missing_heat.brought import brought
from estimator.missing_heat.misfit import misfit
from estimator.missing_heat.missing_heat import MissingHeat, missing_heat
from estimator.missing_heat.where import by_phase
from estimator.model import Model
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.work import Runs, Workers
from viz.comparison.compared import ComparedRun, HeatAlong, HeatMap, Side
from viz.comparison.comparison import save
from viz.drawing import paths
from viz.drawing.bars import Bars, BarSeries
from viz.drawing.scale import rms
from viz.viewer.printed import print_bars, print_heat, print_maps

DOES = {"driving": ("drive",), "at rest": ("early_stop", "late_stop")}


def save_views(
    path: Path, work: Workspace, models: Sequence[Model], sections: Sequence[Section], figures: Sequence[Bars] = ()
) -> None:
    """Write the views of one model, or of two, before and after; `figures` stand beside the text."""
    with work.terminal.progress(f"writing {path}", None), working() as workers:
        write_views(path, compared(work.rig, models, work.loaded, workers), models, sections, figures)
    work.terminal.say_views(path)


def write_views(
    path: Path,
    runs: Sequence[ComparedRun],
    models: Sequence[Model],
    sections: Sequence[Section],
    figures: Sequence[Bars],
) -> None:
    """Write what is known of one model, or of two."""
    names, tabs = [model.name for model in models], {"Errors": figures, "Channels": by_channel(runs)}
    save(path, runs, names, {tab: some for tab, some in tabs.items() if some}, markdown(sections))


def write_pictures(
    stem: Path, runs: Sequence[ComparedRun], models: Sequence[Model], figures: Sequence[Bars]
) -> dict[str, Path]:
    """Write bars and maps as STEM-WHAT.png; paths by what they show."""
    names = [model.name for model in models]
    pictures = {what: stem.with_name(f"{stem.name}-{what}.png") for what in ("steps", "residuals", "missing-heat")}
    print_bars(pictures["steps"], figures)
    print_maps(pictures["residuals"], runs, names)
    if not len(runs[0].sides[0].heat.places_mm):
        del pictures["missing-heat"]
        return pictures
    print_heat(pictures["missing-heat"], runs, names)
    return pictures


def compared(rig: Rig, models: Sequence[Model], loaded: Sequence[Loaded], workers: Workers = map) -> list[ComparedRun]:
    """Run each model over all recordings; of effects that the last one has more than the first, what they bring."""
    recordings = [one.recording for one in loaded]
    added = tuple(name for name in models[-1].effects if name not in models[0].effects)
    sides = [_sides(model, added if model is models[-1] else (), Runs(rig, recordings, workers)) for model in models]
    return [
        ComparedRun(one.path.stem, rig, r.time_s, r.channels, own, _travel(r, rig), added)
        for one, r, own in zip(loaded, recordings, zip(*sides, strict=True), strict=True)
    ]


def error_bars(errors: Sequence[tuple[str, Error, Error | None]]) -> list[Bars]:
    """Open-loop errors by title: on recordings left out, and on those held out where there are some."""
    titles, left_out, held_out = zip(*errors, strict=True)
    kinds = (("cross-validated", left_out, paths.CROSS_VALIDATED), ("held out", held_out, paths.HELD_OUT))
    figures = []
    for what, unit, key in (("temperatures", "K", "temperature_K"), ("elongation", "µm", "elongation_um")):
        series = [
            BarSeries(name, np.array([getattr(error, key) if error else np.nan for error in some]), colour)
            for name, some, colour in kinds
            if any(some)
        ]
        figures.append(Bars(f"Model alone, rms of {what} [{unit}]", titles, series))
    return [bars for bars in figures if np.isfinite(bars.values).any()]


def felt_bars(found: AtTheTable) -> Bars:
    """The largest errors of the filter in cooldown, model by model."""
    colours = {"seen": paths.FILTER, "silent": paths.LEFT_OUT}
    series = [
        BarSeries(words, np.array([most(getattr(each, way)) for each in found.felt]), colours[way])
        for way, words in WAYS.items()
    ]
    return Bars(f"Filter in cooldown, at most off [µm], {found.recordings}", found.models, series)


def by_channel(runs: Sequence[ComparedRun]) -> list[Bars]:
    """rms of what each model alone misses, channel by channel over all recordings."""
    rig = runs[0].rig
    kinds = (("thermometer", "K", rig.is_thermometer), ("displacement", "µm", ~rig.is_thermometer))
    return [
        Bars(f"Model alone, rms by {what} [{unit}]", np.array(rig.names)[shown].tolist(), _rms(runs, shown))
        for what, unit, shown in kinds
        if shown.any()
    ]


def _rms(runs: Sequence[ComparedRun], shown: Array) -> list[BarSeries]:
    series = []
    for side in runs[0].named:
        misfit = np.concatenate([run.named[side].misfit[:, shown] for run in runs])
        name = side if len(runs[0].sides) > 1 else "model alone"
        series.append(BarSeries(name, rms(misfit), paths.COMPARED_AS[side]))
    return series


def _sides(model: Model, added: Sequence[str], runs: Runs) -> list[Side]:
    rig = runs.rig
    tracks = runs.each(lambda recording: _kept(recording, rig, model))
    trials = slow_trials_of(model, runs)
    heats = missing_heat(trials.each(lambda trial: misfit(model, trial)), runs.workers)
    return [_side(track, heat, model, added) for track, heat in zip(tracks, heats, strict=True)]


def _kept(recording: Recording, rig: Rig, model: Model) -> dict[str, Array]:
    """What is drawn of a track: its profiles would be most of the memory."""
    track = replay(model, rig, recording)
    keys = ("open_loop", "predicted", "innovation", "elongation_um", "sigma_um", "open_loop_um")
    return {"readings_um": readings(recording, rig, model, track).um, **{key: getattr(track, key) for key in keys}}


def _side(track: dict[str, Array], heat: MissingHeat, model: Model, added: Sequence[str]) -> Side:
    trial, told = heat.misfit.trial, heat.mean[heat.blocks.of_tick]
    more = _by_place(heat, brought(added, trial, trial.pose(model), heat.zones)) if added else None
    return Side(
        **track, misfit_time_s=trial.rest.time_s, misfit=heat.misfit.open_loop,
        heat=_by_place(heat, told), along=_along(heat), brought=more,
    )  # fmt: skip


def _along(heat: MissingHeat) -> HeatAlong:
    """Means over drives and rests, of those that there are."""
    on_screw = _on_screw(heat)
    length_m = np.array([zone.length_m for zone in heat.zones])[on_screw]
    mean, sd = {}, {}
    for name, phases in DOES.items():
        if np.isin(heat.blocks.phase, phases).any():
            W, covariance = by_phase([heat], *phases)
            mean[name], sd[name] = W[on_screw] / length_m, np.sqrt(np.diag(covariance))[on_screw] / length_m
    return HeatAlong(np.array([zone.middle_mm for zone in heat.zones])[on_screw], mean, sd)


def _by_place(heat: MissingHeat, values: Array) -> HeatMap:
    """Of each tick and zone, (T, zones), a map: all of a long rest is one column."""
    phase = heat.blocks.phase
    goes_on = np.append(False, (phase[1:] == phase[:-1]) & (phase[1:] == "late_stop"))
    of_tick = (np.cumsum(~goes_on) - 1)[heat.blocks.of_tick]
    begins = np.unique(of_tick, return_index=True)[1]
    mean = np.stack([np.bincount(of_tick, column) for column in values.T], axis=-1) / np.bincount(of_tick)[:, None]
    places, on_screw = np.array([zone.middle_mm for zone in heat.zones]), _on_screw(heat)
    bodies = [str(zone.node) for zone in heat.zones if zone.node is not None]
    return HeatMap(
        heat.misfit.trial.rest.time_s[begins], phase[~goes_on].tolist(), places[on_screw], mean[:, on_screw],
        bodies, mean[:, ~on_screw],
    )  # fmt: skip


def _on_screw(heat: MissingHeat) -> Array:
    return np.array([zone.node is None for zone in heat.zones], dtype=bool)


def _travel(recording: Recording, rig: Rig) -> tuple[float, float] | None:
    """Where the nut's ends have been, mm."""
    position = recording.inputs.get("position", np.empty(0))
    if rig.nut is None or not np.isfinite(position).any():
        return None
    centre, half = rig.nut.centre(position), rig.nut.length_mm / 2
    return float(np.nanmin(centre) - half), float(np.nanmax(centre) + half)
