"""The open-loop misfit of one recording as averages over minutes, and how heat anywhere at any time would move it.

    y = A h + (errors of the readings) + scatter

A misfit of heat and of lasting errors is slow; averaged, a recording of hours is a thousand numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from estimator.batch.open_loop import open_loop_misfit
from estimator.batch.trial import Posed, Trial
from estimator.missing_heat.blocks import Blocks, blocks
from estimator.missing_heat.zones import Zone, heat_of, zones
from estimator.model import Model
from estimator.network.assemble import Network
from estimator.record import Array
from estimator.sensitivity.sensitivity import nominal_columns
from estimator.sensitivity.tangent import Tangent

SPIKE = 6.0  # sd from the middle of its bin, from which on a reading does not count


@dataclass(frozen=True)
class Misfit:
    """N averages of a recording.

    open_loop  (T, m) reading minus the model alone at each tick; NaN where not measured, or a spike
    y, variance  (N,) average misfit, K or um, and the variance of its scatter
    channel, bin  (N,) which channel, and which bin of `blocks`
    rate  (N,) how fast the model's reading rises, K/s or um/s
    A  (N, B Z) how an average moves with 1 W/m in zone z during block b, column b Z + z
    """

    trial: Trial
    blocks: Blocks
    zones: tuple[Zone, ...]
    open_loop: Array
    y: Array
    variance: Array
    channel: Array
    bin: Array
    rate: Array
    A: Array


def misfit(model: Model, trial: Trial) -> Misfit:
    """Run the model alone beside a recording, at a tick that serves for slow heat."""
    posed, tick_s = trial.pose(model), trial.rig.tick_s
    cut = blocks(trial.rest, tick_s)
    rest = open_loop_misfit(trial, posed)
    m = rest.shape[1]
    cell = cut.bin_of_tick[:, None] * m + np.arange(m)
    rest = np.where(spikes(rest, cell, posed.forcing.readings.sd), np.nan, rest)
    known = np.isfinite(rest)
    rows, row = np.unique(cell[known], return_inverse=True)
    count = np.bincount(row)

    def mean(values: Array) -> Array:
        return np.asarray(np.bincount(row, values[known]) / count)

    places = zones(trial.rig, posed.forcing.place)
    moved = nominal_columns(posed, _tangents(trial, posed, cut, places))
    A = np.array([mean(column.reading) for column in moved]).T.reshape(len(rows), -1)
    variance = mean(np.broadcast_to(posed.system.R, rest.shape)) / count
    rate = np.diff(posed.run.lagged, axis=0, prepend=posed.run.spot[:1]) / tick_s
    return Misfit(trial, cut, places, rest, mean(rest), variance, rows % m, rows // m, mean(rate), A)


def _tangents(trial: Trial, posed: Posed, cut: Blocks, places: tuple[Zone, ...]) -> Iterator[Tangent]:
    """The heat of each block and zone."""
    none = Network.none(posed.forcing.place, len(posed.system.F))
    still, calm = np.zeros_like(posed.outside), np.zeros_like(trial.rest.channels)
    into = [heat_of(zone, trial.rig, posed.forcing.place) for zone in places]
    for block in range(len(cut)):
        during = (cut.of_tick == block).astype(float)[:, None]
        for heat in into:
            yield Tangent(none, during * heat, still, calm, None)


def spikes(rest: Array, cell: Array, sd: Array) -> Array:
    """Readings far from the others of their bin, (T, m)."""
    known = np.isfinite(rest)
    middle, spread = np.full((2, cell.max() + 1), np.nan)
    order = np.argsort(cell[known], kind="stable")
    cells, first = np.unique(cell[known][order], return_index=True)
    for which, values in zip(cells, np.split(rest[known][order], first[1:]), strict=True):
        middle[which] = np.median(values)
        spread[which] = 1.48 * np.median(np.abs(values - middle[which]))
    return np.asarray(np.abs(rest - middle[cell]) > SPIKE * np.maximum(spread[cell], sd))
