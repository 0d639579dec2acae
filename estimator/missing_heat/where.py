"""Where and when heat is missing: neighbouring zones together, phase by phase, over all recordings."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.accuracy.noise_floor import Error
from estimator.inputs.phase import PHASES
from estimator.missing_heat.follows import Follows, heat_follows
from estimator.missing_heat.missing_heat import MissingHeat
from estimator.record import Array

SURE = 3.0  # sd
TOLD = 0.8  # heat of a body that comes and goes may be none on the mean: what it follows explains this share of it
MATTERS = 0.5  # effect
GAP = 2  # zones between others of one peak
SHADOW = 0.3  # of the largest effect: less may be what a large failure is not described by
SHOULDER = 0.25  # of a peak's heat per length, down to which its neighbours belong to it


@dataclass(frozen=True)
class Deficit:
    """Heat that is missing in some neighbouring zones, or a body (`node`), during one phase.

    heat_W, sd_W  mean over the time of this phase in all recordings; positive: the model lacks it
    effect   rms that it adds to thermometers or displacement, whichever suffers more, over what is good enough
    """

    from_mm: float | None
    to_mm: float | None
    node: str | None
    phase: str
    heat_W: float
    sd_W: float
    effect: float
    follows: Follows


def where(found: Sequence[MissingHeat], limits: Error) -> tuple[Deficit, ...]:
    """All heat that is surely missing and matters, largest first."""
    listed: list[Deficit] = []
    for phase in PHASES:
        if not any((each.blocks.phase == phase).any() for each in found):
            continue
        mean, covariance = by_phase(found, phase)
        for run in _material(found, phase, list(_runs(mean, found[0])), limits):
            heat, sd = float(mean[run].sum()), float(np.sqrt(covariance[np.ix_(run, run)].sum()))
            zones = [found[0].zones[z] for z in run]
            sure = abs(heat) > SURE * sd
            if sure or zones[0].node is not None:
                told = heat_follows(found, run)
                if not sure and (told.name is None or told.explains < TOLD):
                    continue
                effect = _effect(found, phase, run, limits)
                listed.append(Deficit(zones[0].from_mm, zones[-1].to_mm, zones[0].node, phase, heat, sd, effect, told))
    return tuple(sorted(listed, key=lambda each: -abs(each.heat_W)))


def _material(found: Sequence[MissingHeat], phase: str, runs: list[list[int]], limits: Error) -> list[list[int]]:
    """Runs of zones that matter, without neighbours that matter only as long as they do not cancel each other."""
    kept = [run for run in runs if _effect(found, phase, run, limits) > MATTERS]
    for one in list(kept):
        for other in list(kept):
            if one[-1] + 1 == other[0] and _effect(found, phase, [*one, *other], limits) < MATTERS:
                kept = [run for run in kept if run not in (one, other)]
    return kept


def together(heat: Sequence[Deficit]) -> list[list[Deficit]]:
    """The same heat in several phases: of one sign, at places that overlap, and alike in size; largest first."""
    groups: list[list[Deficit]] = []
    for each in heat:
        like = next((group for group in groups if _same(group[0], each)), None)
        if like is None:
            groups.append([each])
        else:
            like.append(each)
    return groups


def _same(one: Deficit, other: Deficit) -> bool:
    near = one.node == other.node
    if one.from_mm is not None and one.to_mm is not None and other.from_mm is not None and other.to_mm is not None:
        near = one.from_mm < other.to_mm and other.from_mm < one.to_mm
    return near and one.phase != other.phase and 0.5 < other.heat_W / one.heat_W < 2.0


def by_phase(found: Sequence[MissingHeat], *phases: str) -> tuple[Array, Array]:
    """Heat of each zone during some phases, (Z,) W, mean over their time in all recordings, and covariance (Z, Z)."""
    length = np.array([zone.length_m for zone in found[0].zones])
    spent = sum(each.blocks.seconds[np.isin(each.blocks.phase, phases)].sum() for each in found)
    mean, covariance = np.zeros(len(length)), np.zeros((len(length), len(length)))
    for each in found:
        share = np.where(np.isin(each.blocks.phase, phases), each.blocks.seconds, 0.0) / spent
        total = np.kron(share, np.diag(length))
        mean += total @ each.mean.ravel()
        covariance += total @ each.covariance @ total.T
    return mean, covariance


def _runs(mean: Array, found: MissingHeat) -> Iterator[list[int]]:
    """Neighbouring zones whose heat has one sign and belongs to one peak, highest peak first; bodies alone."""
    density = mean / np.array([zone.length_m for zone in found.zones])
    on_screw = [zone.node is None for zone in found.zones]
    free = set(range(len(mean)))
    for peak in np.argsort(-np.abs(density)).tolist():
        if peak in free:
            belongs = density * np.sign(density[peak]) >= SHOULDER * abs(density[peak])
            belongs &= [z in free and on_screw[z] and on_screw[peak] for z in range(len(mean))]
            run = [peak, *_reach(peak, -1, belongs, free), *_reach(peak, 1, belongs, free)]
            free -= set(run)
            yield sorted(run)


def _reach(peak: int, step: int, belongs: Array, free: set[int]) -> list[int]:
    """Zones on one side of a peak that belong to it, and gaps of so few that thermometers cannot tell them."""
    run: list[int] = []
    gap: list[int] = []
    z = peak + step
    while z in free and len(gap) <= GAP:
        gap.append(z)
        if belongs[z]:
            run, gap = run + gap, []
        z += step
    return run


def _effect(found: Sequence[MissingHeat], phase: str, run: Sequence[int], limits: Error) -> float:
    """rms that this heat adds to thermometers or displacement, over what is good enough; the larger of both."""
    heat_family = found[0].misfit.trial.rig.is_thermometer
    squares, ticks = np.zeros((2, len(heat_family)))
    for each in found:
        heat, misfit = np.zeros_like(each.mean), each.misfit
        during = np.ix_(each.blocks.phase == phase, run)
        heat[during] = each.mean[during]
        moved = misfit.A @ heat.ravel()
        weight = each.blocks.ticks[misfit.bin].astype(float)
        for channel in misfit.trial.floating:
            own = misfit.channel == channel
            if own.any():
                moved[own] -= np.average(moved[own], weights=weight[own])
        np.add.at(squares, misfit.channel, weight * moved**2)
        np.add.at(ticks, misfit.channel, weight)
    families = ((heat_family, limits.temperature_K), (~heat_family, limits.elongation_um))
    return max(float(np.sqrt(squares[f].sum() / max(ticks[f].sum(), 1.0))) / limit for f, limit in families)
