"""Doubts about the order of the thermometers: two of which the profile would be much smoother the other way round.

Only where heat has had time to even out: a quarter of an hour after the last drive peaks at the bearings are gone, and
what is still uneven is more likely a wrong place. On a rig without a drive any time will do.
"""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ballscrew.doubts.doubt import Case, Doubt
from drivers.frames import Array

_SETTLED_S, _LONG_S = 900.0, 300.0  # since the last drive, and how much of that there must be
_FEWEST = 5  # thermometers whose order shows
_SMOOTHER = 0.6  # the other way round; on sound rigs it was 0.9 at least
_UNEVEN_K = 0.1  # a smoother profile says nothing
_PARTS = 40


def order(case: Case) -> Iterator[Doubt]:
    """The pair that fits best the other way round, if clearly."""
    names = case.on_the_screw
    profile = _settled(case)
    if profile is None:
        return
    x_mm = np.array([case.rig.channels[name].at_mm for name in names])
    base = roughness(x_mm, profile)
    pairs = {pair: roughness(x_mm, _swapped(profile, pair)) for pair in combinations(range(len(names)), 2)}
    best = min(pairs, key=lambda pair: pairs[pair])
    if base > _UNEVEN_K and pairs[best] < _SMOOTHER * min(base, *(_without(x_mm, profile, k) for k in best)):
        one, other = (names[k] for k in best)
        what = f"{one} and {other}: the profile is {base / pairs[best]:.1f} times as smooth the other way round"
        yield Doubt("rig.toml: channels", what, "look whether their places, or their signals, are exchanged")


def roughness(x_mm: Array, profile: Array) -> float:
    """How far thermometers are off a line between their neighbours, rms of (rows, n), K."""
    weight = (x_mm[1:-1] - x_mm[:-2]) / (x_mm[2:] - x_mm[:-2])
    between = profile[:, :-2] + weight * (profile[:, 2:] - profile[:, :-2])
    return float(np.sqrt(np.mean((profile[:, 1:-1] - between) ** 2)))


def _without(x_mm: Array, profile: Array, one: int) -> float:
    """The roughness without one of them: a thermometer that is dead is no matter of order."""
    return roughness(np.delete(x_mm, one), np.delete(profile, one, axis=1))


def _swapped(profile: Array, pair: tuple[int, int]) -> Array:
    other = profile.copy()
    other[:, pair] = profile[:, pair[::-1]]
    return other


def _settled(case: Case) -> Array | None:
    """Rises, (rows, n) K, where the profile has settled; None where there is too little of it."""
    omega, ticks = case.recording.omega, np.arange(len(case.recording))
    driven = np.maximum.accumulate(np.where(omega > 0, ticks, -1))
    settled = (driven >= 0) & ((ticks - driven) * case.rig.tick_s > _SETTLED_S)
    rows = settled if (omega > 0).any() else np.ones(len(ticks), bool)
    places = {case.rig.channels[name].at_mm for name in case.on_the_screw}
    if len(places) < max(_FEWEST, len(case.on_the_screw)) or rows.sum() * case.rig.tick_s < _LONG_S:
        return None
    parts = [part for part in np.array_split(case.rises[rows], _PARTS) if np.isfinite(part).any(axis=0).all()]
    return np.array([np.nanmean(part, axis=0) for part in parts]) if len(parts) > _PARTS // 2 else None
