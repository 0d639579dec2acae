"""What the missing heat and the errors of readings are held against: followers, averaged over the same blocks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.follows import Series
from estimator.horizon import Error
from estimator.missing_heat import ALL, MissingHeat
from estimator.record import Array
from estimator.rig import Rig
from estimator.unknown import TEMPERATURE, followers, following

GOOD_K, GOOD_UM = 0.05, 0.2  # rms open loop that a good model leaves ...
RATE = "rate"  # of the temperature's change
FLOORS = 2.0  # ... or so many times what the sensors leave, if that is more


@dataclass(frozen=True)
class Limits:
    """rms that is good enough: of thermometers, K, and of the displacement, um; and which channel is which, (m,)."""

    temperature_K: float
    elongation_um: float
    thermometers: Array


def limits_of(rig: Rig, floor: Error) -> Limits:
    """What is good enough for a rig whose sensors leave this."""
    heat = float(np.fmax(GOOD_K, FLOORS * floor.temperature_K))
    length = float(np.fmax(GOOD_UM, FLOORS * floor.elongation_um))
    return Limits(heat, length, np.isin(rig.names, rig.thermometers))


def names(found: MissingHeat) -> tuple[str, ...]:
    """Names of the followers on the rig of a recording, the temperature at the place and its rate last."""
    return (*followers(found.misfit.trial.rig), TEMPERATURE, RATE)


def heat_series(found: MissingHeat, zones: Sequence[int]) -> Series:
    """Heat of some zones together, W, block by block."""
    length = np.zeros(len(found.zones))
    length[list(zones)] = [found.zones[z].length_m for z in zones]
    total = np.kron(np.eye(len(found.blocks)), length)
    sd = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", total, found.covariance, total), 0.0))
    rig, ends = found.misfit.trial.rig, [found.zones[z] for z in zones]
    places = [(z.from_mm + z.to_mm) / 2 for z in ends if z.from_mm is not None and z.to_mm is not None]
    near = _near(rig, float(np.mean(places))) if places else _on(rig, ends[0].node)
    everything = np.ones(len(found.blocks.of_tick), dtype=bool)
    return Series(found.mean @ length, sd, _followers(found, near, everything, found.blocks.mean))


def reading_series(found: MissingHeat, name: str) -> Series:
    """Error of one channel, or of all thermometers together, bin by bin."""
    error, rig = found.readings[name], found.misfit.trial.rig
    own = name != ALL and name in rig.thermometers
    near = np.isin(rig.names, [name] if own else rig.thermometers) / (1 if own else len(rig.thermometers))
    shown = slice(None) if name == ALL else [rig.index(name)]
    read = np.asarray(np.isfinite(found.misfit.open_loop[:, shown]).any(axis=1))
    sd = np.sqrt(np.maximum(np.diag(error.covariance), 0.0))
    return Series(error.mean, sd, _followers(found, near, read, found.blocks.bin_mean)[error.bins])


def _followers(found: MissingHeat, near: Array, read: Array, mean: Callable[[Array], Array]) -> Array:
    """Followers averaged over the ticks of each block or bin that were `read` (T,), (b, F); `near` weighs channels."""
    trial = found.misfit.trial
    u, used = trial.drive.inputs, np.flatnonzero(near)
    columns = [following(name, u, trial.rig)[1:, 0] for name in followers(trial.rig)]
    columns.append(_held(trial.rest.channels[:, used]) @ near[used])
    columns.append(np.gradient(columns[-1], trial.rig.tick_s) if len(read) > 1 else np.zeros(1))
    return np.stack([mean(np.where(read, column, np.nan)) for column in columns], axis=1)


def _held(readings: Array) -> Array:
    """Readings (T, r) with gaps filled by straight lines; 0 for one that was never read."""
    ticks = np.arange(len(readings))
    known = np.isfinite(readings)
    filled = [
        np.interp(ticks, ticks[at], column[at]) if at.any() else np.zeros(len(ticks))
        for column, at in zip(readings.T, known.T, strict=True)
    ]
    return np.stack(filled, axis=1)


def _near(rig: Rig, at_mm: float) -> Array:
    """Weights (m,) of the thermometers on both sides of a place."""
    weights = np.zeros(len(rig.names))
    on_screw = sorted((c.at_mm, rig.index(name)) for name, c in rig.channels.items() if c.at_mm is not None)
    places = np.array([at for at, _ in on_screw])
    for (_, channel), share in zip(on_screw, np.eye(len(places)), strict=True):
        weights[channel] = np.interp(at_mm, places, share)
    return weights


def _on(rig: Rig, node: str | None) -> Array:
    """Weights (m,) of the thermometers on a body."""
    on = np.array([channel.node == node for channel in rig.channels.values()], dtype=float)
    return np.asarray(on / max(on.sum(), 1))
