"""A part of the model that does more from recording to recording, by their clocks: a bearing that wears."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.special import stdtr

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
    judged = [(_chance(shares), name, shares) for name in names for shares in [_shares(name, dated, solvers)]]
    chance, name, shares = min(judged, default=(1.0, "", np.zeros(2)), key=lambda one: one[0])
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


def _shares(name: str, seen: Sequence[Signature], solvers: Sequence[Solver]) -> np.ndarray:
    """By which share of itself the part differs from the model, in each recording, (R,)."""
    found = []
    for each, solver in zip(seen, solvers, strict=True):
        column = sum(each.moves[:, :, c].sum(axis=1) for c, one in enumerate(each.carriers) if one.name == name)
        found.append(float(solver.judged(np.reshape(column, (-1, 1)))[1][0]))
    return np.array(found)


def _chance(shares: np.ndarray) -> float:
    """That a line through R values is so steep, beside their scatter; 1 where not each is beyond the one before."""
    steps = np.diff(shares)
    if abs(np.sign(steps).sum()) < len(steps):
        return 1.0
    order = np.arange(len(shares)) - (len(shares) - 1) / 2
    slope = order @ shares / (order @ order)
    left = shares - shares.mean() - slope * order
    sd = np.sqrt(left @ left / (len(shares) - 2) / (order @ order))
    return float(2 * stdtr(len(shares) - 2, -abs(slope) / max(sd, 1e-12)))
