"""A part of the model that does more from recording to recording, by their clocks: a bearing that wears."""

from collections.abc import Mapping, Sequence

import numpy as np
import scipy

from estimator.events.event import GROWING, PART, Event
from estimator.events.onset import Solver
from estimator.events.pattern import pattern
from estimator.events.signature import Signature

FEWEST = 4  # recordings, of which each has to have more than the one before it
CHANCE = 0.01  # that a straight line rises so clearly, for all parts that are tried together
LEAST_SHARE = 0.1  # from the first to the last


def growing(seen: Sequence[Signature], sizes: Mapping[str, float]) -> list[Event]:
    """The part that grows or shrinks most clearly, told of the last recording; none without the recordings' dates."""
    dated = sorted(
        (each for each in seen if each.trial.recording.began_s is not None),
        key=lambda each: each.trial.recording.began_s or 0.0,
    )
    if len(dated) < FEWEST:
        return []
    solvers = [Solver(pattern(each), sizes) for each in dated]
    names = [carrier.name for carrier in dated[0].carriers if carrier.kind == PART]
    parts = [(name, *_shares(name, dated, solvers)) for name in names]
    if not parts:
        return []
    scatter = np.sqrt(np.mean([_left(shares, sd) for _, shares, sd in parts]))
    freedom = len(parts) * (len(dated) - 2)
    chance, name, shares = min((_chance(shares, scatter * sd, freedom), name, shares) for name, shares, sd in parts)
    rise = float(shares[-1] - shares[0])
    if chance * len(names) > CHANCE or abs(rise) < LEAST_SHARE:
        return []
    recordings = [each.trial.recording for each in dated]
    more = "more" if rise > 0 else "less"
    what = (
        f"{name} does {abs(100 * rise):.0f} % {more} than in {recordings[0].name}, {more} from each recording to the "
        "next: look at that bearing, its preload and its grease"
    )
    last = recordings[-1]
    return [Event(last.name, 0.0, 0.0, GROWING, began_s=last.began_s, name=name, share=rise, what=what)]


def _shares(
    name: str, seen: Sequence[Signature], solvers: Sequence[Solver]
) -> tuple[tuple[float, ...], np.ndarray]:  # fmt: skip
    """By which share of itself the part differs from the model in each recording, and its sd, R each."""
    found = []
    for each, solver in zip(seen, solvers, strict=True):
        column = sum(each.moves[:, :, c].sum(axis=1) for c, one in enumerate(each.carriers) if one.name == name)
        _, share, sd = solver.judged(np.reshape(column, (-1, 1)))
        found.append((float(share[0]), float(sd[0])))
    return tuple(share for share, _ in found), np.array([sd for _, sd in found])


def _left(shares: Sequence[float], sd: np.ndarray) -> float:
    """Mean square of what a line leaves of R shares, in sd, by degree of freedom.

    Parts together tell it: how recordings of other patterns and speeds differ is no part's own.
    """
    order = np.arange(len(shares))
    left = np.array(shares) - np.polyval(np.polyfit(order, shares, 1), order)
    return float(((left / sd) ** 2).sum() / (len(shares) - 2))


def _chance(shares: Sequence[float], sd: np.ndarray, freedom: int) -> float:
    """That a line through R shares is so steep; 1 where not each is beyond the one before."""
    steps = np.diff(shares)
    if abs(np.sign(steps).sum()) < len(steps):
        return 1.0
    order = np.arange(len(shares)) - (len(shares) - 1) / 2
    of_slope = np.sqrt((order**2 * sd**2).sum())
    return float(2 * scipy.special.stdtr(freedom, -abs(order @ np.array(shares)) / max(of_slope, 1e-12)))
