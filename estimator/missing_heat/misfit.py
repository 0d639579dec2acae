"""The open-loop misfit of one recording as averages over minutes, and how heat anywhere at any time would move it.

    y = A h + (errors of the readings) + scatter

A misfit of heat and of lasting errors is slow; averaged, a recording of hours is a thousand numbers.
"""

from dataclasses import dataclass, replace

import numpy as np

from estimator.batch.open_loop import open_loop_misfit
from estimator.batch.trial import Trial
from estimator.missing_heat.blocks import Blocks, blocks
from estimator.missing_heat.zones import Zone, heat_of, zones
from estimator.model import Model
from estimator.record import Array
from estimator.sensitivity.averages import Averaged, moves

MOST = 1000  # averages that are likely together: the work grows with the cube of their number
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

    def parts(self) -> "list[Misfit]":
        """The same as recordings of `MOST` averages at most, in order of time: one of four hours is whole."""
        many = np.array_split(np.arange(len(self.y)), -(-len(self.y) // MOST))
        series = ("y", "variance", "channel", "bin", "rate", "A")
        return [replace(self, **{key: getattr(self, key)[rows] for key in series}) for rows in many]


def misfit(model: Model, trial: Trial) -> Misfit:
    """Run the model alone beside a recording, at a tick that serves for slow heat."""
    posed, tick_s = trial.pose(model), trial.rig.tick_s
    cut = blocks(trial.rest, tick_s, trial.block_s)
    rest = open_loop_misfit(trial, posed)
    m = rest.shape[1]
    cell = cut.bin_of_tick[:, None] * m + np.arange(m)
    rest = np.where(spikes(rest, cell, posed.forcing.readings.sd), np.nan, rest)
    averaged, rows = Averaged.of(cell, np.isfinite(rest))
    places = zones(trial.rig, posed.forcing.place)
    into = np.stack([heat_of(zone, trial.rig, posed.forcing.place) for zone in places], axis=1)
    push = {r: posed.forcing.transition(r).J @ into for r in set(posed.system.regime.tolist())}
    A = moves(posed, [push[r] for r in posed.system.regime.tolist()], cut.of_tick, averaged).reshape(len(rows), -1)
    variance = averaged.mean(np.broadcast_to(posed.system.R, rest.shape)) / averaged.count
    rate = np.diff(posed.run.lagged, axis=0, prepend=posed.run.spot[:1]) / tick_s
    return Misfit(
        trial, cut, places, rest, averaged.mean(rest), variance, rows % m, rows // m, averaged.mean(rate), A
    )  # fmt: skip


def spikes(rest: Array, cell: Array, sd: Array) -> Array:
    """Readings far from the others of their bin, (T, m)."""
    known = np.isfinite(rest)
    if not known.any():
        return known
    middle, spread = np.full((2, cell.max() + 1), np.nan)
    order = np.argsort(cell[known], kind="stable")
    cells, first = np.unique(cell[known][order], return_index=True)
    for which, values in zip(cells, np.split(rest[known][order], first[1:]), strict=True):
        middle[which] = np.median(values)
        spread[which] = 1.48 * np.median(np.abs(values - middle[which]))
    return np.asarray(np.abs(rest - middle[cell]) > SPIKE * np.maximum(spread[cell], sd))
