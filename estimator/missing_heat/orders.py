"""Other orders of the values of some recordings, by which chance is told: neighbours stay neighbours."""

from collections.abc import Sequence

import numpy as np

from estimator.record import Array

SEED = 1
ORDERS = 500


def orders(lengths: Sequence[int]) -> Array:
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
