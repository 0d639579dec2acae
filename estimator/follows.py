"""What a series of values over time follows, and whether that may be chance.

Each follower is regressed on, with a constant; the best explains the largest share of the variance. How large a share
chance and the choice among many followers would reach is told by the same values in other orders: recordings are
exchanged, and the values of each laid out in a circle, there and back, to be read from anywhere on. So neighbours stay
neighbours, and what differs between recordings keeps doing so. One recording has too few orders for a name.
A series that hardly varies and is surely not zero is "always" there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import erfc

import numpy as np

from estimator.record import Array

SEED = 1
ORDERS = 500
CHANCE = 0.01  # p below which a follower is named
UNEXPLAINED = 0.1  # of the variance, beside the values' own sd, that no follower is expected to explain
CONSTANT = 0.8  # of the power, from which on the mean is all that there is
ALWAYS = "always"


@dataclass(frozen=True)
class Series:
    """Values (b,) of one recording's blocks with their sd (b,), and the followers there, (b, F)."""

    values: Array
    sd: Array
    followers: Array


@dataclass(frozen=True)
class Follows:
    """The best follower, None where it may be chance; p; and the share of the variance that it explains."""

    name: str | None
    p: float
    explains: float


def follows(series: Sequence[Series], names: Sequence[str], steady: bool = True) -> Follows:
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
    orders = _orders([len(each.values) for each in series])
    mixed = scaled[orders]
    mixed -= (mixed @ np.sqrt(weight))[:, None] * np.sqrt(weight) / weight.sum()
    chance = ((mixed @ shapes) ** 2).max(axis=1) / np.maximum((mixed**2).sum(axis=1), 1e-300)
    p = (1 + int((chance >= found[best] - 1e-9).sum())) / (1 + len(orders))
    return Follows(names[best] if p < CHANCE else None, p, float(found[best]))


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


def _orders(lengths: Sequence[int]) -> Array:
    """Other orders of the values of recordings of these lengths, (orders, b)."""
    dice = np.random.default_rng(SEED)
    first = np.append(0, np.cumsum(lengths))
    found = []
    for _ in range(ORDERS):
        given = dice.permutation(len(lengths))
        found.append(
            np.concatenate([first[g] + _order(lengths[g], n, dice) for g, n in zip(given, lengths, strict=True)])
        )
    return np.array(found)


def _order(length: int, wanted: int, dice: np.random.Generator) -> Array:
    """One recording's values there and back in a circle, from anywhere on, for as many blocks as are wanted."""
    there = np.arange(length)
    return np.append(there, there[::-1])[
        (np.arange(wanted) * length // wanted + dice.integers(2 * length)) % (2 * length)
    ]
