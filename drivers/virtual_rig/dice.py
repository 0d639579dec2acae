"""Random numbers that depend only on the seed and on what they are for."""

import zlib

import numpy as np


def dice(seed: int, *purpose: str) -> np.random.Generator:
    """A stream of its own for each purpose; what belongs to the rig leaves the run's name out of it."""
    return np.random.default_rng([seed, *(zlib.crc32(word.encode()) for word in purpose)])
