"""What a series of values over time follows, and whether that may be chance.

Each follower is regressed on, with a constant; the best explains the largest share of the variance. How large a share
chance and the choice among many followers would reach is told by the same values in other orders: recordings are
exchanged, and the values of each laid out in a circle, there and back, to be read from anywhere on. So neighbours stay
neighbours, and what differs between recordings keeps doing so. One recording has too few orders for a name.
A series that hardly varies and is surely not zero is "always" there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import erfc

import numpy as np

from estimator.inputs.follower import ALWAYS, RATE, TEMPERATURE, Follower, followers, products
from estimator.inputs.reach import reaches
from estimator.missing_heat.missing_heat import ALL, MissingHeat
from estimator.missing_heat.orders import orders
from estimator.record import Array
from estimator.rig import Rig

CHANCE = 0.01  # p below which a follower is named
UNEXPLAINED = 0.1  # of the variance, beside the values' own sd, that no follower is expected to explain
RIVALS = 3  # that are named
LIKELY = 4.0  # of the variance of what is left, by which squares may differ for two to be alike
CONSTANT = 0.8  # of the power, from which on the mean is all that there is


@dataclass(frozen=True)
class Series:
    """Values (b,) of one recording's blocks with their sd (b,), and the followers there, (b, F)."""

    values: Array
    sd: Array
    followers: Array


@dataclass(frozen=True)
class Follows:
    """The best follower, None where it may be chance; p; and the share of the variance that it explains.

    rivals  followers that explain as much within two standard errors of the difference, best first
    """

    follower: Follower | None
    p: float
    explains: float
    rivals: tuple[Follower, ...] = ()

    @property
    def name(self) -> str | None:
        """The follower's name."""
        return self.follower.name if self.follower else None


def follows(series: Sequence[Series], known: Sequence[Follower], steady: bool = True) -> Follows:
    """What the series of some recordings follow together; `steady`: whether their mean has a meaning."""
    y = np.concatenate([each.values for each in series])
    sd = np.concatenate([each.sd for each in series])
    if len(y) < 3:
        return Follows(None, 1.0, 0.0)
    weight = 1.0 / np.maximum(sd**2 + UNEXPLAINED * np.var(y), 1e-300)
    mean = weight @ y / weight.sum()
    share = weight.sum() * mean**2 / max(weight @ y**2, 1e-300)
    if steady and share >= CONSTANT:
        return _always(series, share)
    scaled = (y - mean) * np.sqrt(weight)
    shapes = _shapes(np.concatenate([each.followers for each in series]), np.sqrt(weight))
    found = (scaled @ shapes) ** 2 / max(scaled @ scaled, 1e-300)
    best = int(np.argmax(found))
    others = orders([len(each.values) for each in series])
    mixed = scaled[others]
    mixed -= (mixed @ np.sqrt(weight))[:, None] * np.sqrt(weight) / weight.sum()
    chance = ((mixed @ shapes) ** 2).max(axis=1) / np.maximum((mixed**2).sum(axis=1), 1e-300)
    p = (1 + int((chance >= found[best] - 1e-9).sum())) / (1 + len(others))
    if p >= CHANCE:
        return Follows(None, p, float(found[best]))
    return Follows(known[best], p, float(found[best]), tuple(known[k] for k in _rivals(scaled, shapes, found, best)))


def _rivals(scaled: Array, shapes: Array, found: Array, best: int) -> list[int]:
    """Others whose squares of what is left, block by block, add up to no more than those of the best, best first.

    Within two standard errors of the sum of the differences, in which neighbours are alike, or of a likelihood that is
    as good but for a factor of seven.
    """
    left = (scaled[:, None] - shapes * (scaled @ shapes)) ** 2
    more = left - left[:, [best]]
    apart = more - more.mean(axis=0)
    variance = (apart**2).sum(axis=0) + 2 * np.maximum((apart[1:] * apart[:-1]).sum(axis=0), 0.0)
    least = LIKELY * left[:, best].sum() / max(len(scaled) - 2, 1)
    as_good = (more.sum(axis=0) < np.maximum(2 * np.sqrt(variance), least)) & shapes.any(axis=0)
    return [int(k) for k in np.argsort(-found) if as_good[k] and k != best][:RIVALS]


def _always(series: Sequence[Series], share: float) -> Follows:
    """Whether the mean is surely not zero: by the values' sd, and by how recordings differ."""
    means = np.array([np.mean(each.values) for each in series])
    own = np.sqrt(np.mean([np.mean(each.sd**2) for each in series]) / len(means))
    between = np.std(means) / np.sqrt(max(len(means) - 1, 1))
    p = erfc(abs(float(np.mean(means))) / max(float(np.hypot(own, between)), 1e-300) / np.sqrt(2))
    return Follows(ALWAYS if p < CHANCE else None, p, share)


def _shapes(followers: Array, root: Array) -> Array:
    """Weighted followers, (b, F), without their mean and of length 1; zeros where one does not vary."""
    followers = np.where(np.isfinite(followers), followers, 0.0)
    centred = followers - (root**2 @ followers) / (root**2).sum()
    varies = centred.std(axis=0) > 1e-6 * np.maximum(np.abs(followers).max(axis=0), 1e-12)
    scaled = centred * root[:, None]
    return np.where(varies, scaled / np.maximum(np.linalg.norm(scaled, axis=0), 1e-300), 0.0)


def followers_there(found: MissingHeat) -> tuple[Follower, ...]:
    """What heat and readings of a recording are held against, the temperature at the place and its rate last."""
    return (*_of_inputs(found.misfit.trial.rig), TEMPERATURE, RATE)


def heat_follows(found: Sequence[MissingHeat], zones: Sequence[int]) -> Follows:
    """What heat of some zones together follows, of all that can drive heat there."""
    known, there = followers_there(found[0]), [found[0].zones[z] for z in zones]
    places = [place for zone in there for place in (zone.from_mm, zone.to_mm) if place is not None]
    near = [k for k, follower in enumerate(known) if reaches(follower, found[0].misfit.trial.rig, places)]
    all_of_them = [heat_series(each, zones) for each in found]
    series = [replace(each, followers=each.followers[:, near]) for each in all_of_them]
    return follows(series, [known[k] for k in near])


def _of_inputs(rig: Rig) -> tuple[Follower, ...]:
    """What is known of every tick: shapes of the motion, their products with fading ones, and inputs."""
    return (*followers(rig)[:-1], *products(rig))


def heat_series(found: MissingHeat, zones: Sequence[int]) -> Series:
    """Heat of some zones together, W, block by block."""
    length = np.zeros(len(found.zones))
    length[list(zones)] = [found.zones[z].length_m for z in zones]
    total = np.kron(np.eye(len(found.blocks)), length)
    sd = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", total, found.covariance, total), 0.0))
    rig, ends = found.misfit.trial.rig, [found.zones[z] for z in zones]
    middle = float(np.mean([zone.middle_mm for zone in ends]))
    near = _near(rig, middle) if np.isfinite(middle) else _on(rig, ends[0].node)
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
    columns = [known.values(u, trial.rig)[1:, 0] for known in _of_inputs(trial.rig)]
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
