"""The most likely onset: generalised likelihood ratio over times and places (Willsky & Jones 1976).

    gain = (c' S^-1 y)^2 / (c' S^-1 c),      size = c' S^-1 y / (c' S^-1 c)

twice the log-likelihood that a step c from a time on adds to the pattern S that a model's misfit always has.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from estimator.events.carriers import Carrier
from estimator.events.event import DRIVING, HOT, READING
from estimator.events.signature import Signature, without_zeros
from estimator.missing_heat.causes import Averages
from estimator.record import Array

FINER = 5  # onsets that are tried within a span
READS_WORSE = 1.5  # times the gain of any heat, from which on a reading is called wrong
NEARLY = 0.9  # of the largest gain
SLACK_S = 100.0  # sd of the sharpest onset: on simulated machines these were off by 70 s (rms), up to 280 s


@dataclass(frozen=True)
class Step:
    """Something from each of the spans on: columns (N, B); acts (B,) whether anything is added in that span."""

    kind: str
    carrier: Carrier | None
    channel: str | None
    columns: Array
    acts: Array


@dataclass(frozen=True)
class Onset:
    """The most likely onset of a step: when, how large, and how much it adds; `column` (N,) by 1 of it."""

    step: Step
    since_s: float
    sd_s: float
    size: float
    sd: float
    gain: float
    column: Array


def steps(seen: Signature) -> Iterator[Step]:
    """Everything that may begin."""
    drive = seen.spans.drive
    for c, carrier in enumerate(seen.carriers):
        moves = seen.moves[:, :, c]
        yield _step(carrier.kind, carrier, moves)
        if carrier.kind == HOT and drive.any() and not drive.all():
            yield _step(DRIVING, carrier, moves * drive)
    spans = np.arange(len(seen.spans))
    for channel in np.unique(seen.channel):
        own = (seen.channel == channel)[:, None] & (seen.span[:, None] == spans)
        zeroed = [np.flatnonzero(own.any(axis=1))] if channel in seen.trial.floating else []
        moves = without_zeros(own.astype(float), zeroed, np.ones(len(own)))
        yield _step(READING, None, moves, seen.trial.rig.names[channel])


def _step(kind: str, carrier: Carrier | None, moves: Array, channel: str | None = None) -> Step:
    from_there = np.cumsum(moves[:, ::-1], axis=1)[:, ::-1]
    return Step(kind, carrier, channel, from_there, np.abs(moves).max(axis=0) > 0)


def best_onset(seen: Signature, measured: Averages, sizes: Mapping[str, float], tried: Sequence[Step]) -> Onset | None:
    """Of all steps; a reading only where no heat explains nearly as much. None where nothing can have begun."""
    solver = Solver(measured, sizes)
    found = [(gain, step) for step in tried for gain in [solver.gains(step)]]
    heat = max(((g.max(), s) for g, s in found if s.kind != READING), default=(0.0, None), key=lambda pair: pair[0])
    reads = max(((g.max(), s) for g, s in found if s.kind == READING), default=(0.0, None), key=lambda pair: pair[0])
    step = reads[1] if reads[0] > READS_WORSE * heat[0] else heat[1]
    return solver.onset(seen, step) if step is not None else None


class Solver:
    """A recording's averages under a pattern."""

    def __init__(self, measured: Averages, sizes: Mapping[str, float]) -> None:
        S = measured.known.copy()
        for name, cause in measured.causes.items():
            S[np.ix_(cause.rows, cause.rows)] += sizes[name] ** 2 * cause.covariance
        self._factor = cho_factor(S)
        self._pull = cho_solve(self._factor, measured.y)

    def gains(self, step: Step) -> Array:
        """Of the onsets with each span, (B,); with the first in which it acts nothing begins: it always was there."""
        gain = self.judged(step.columns)[0]
        first = int(np.flatnonzero(step.acts)[0]) if step.acts.any() else len(gain)
        return np.where(step.acts & (np.arange(len(gain)) > first), gain, 0.0)

    def onset(self, seen: Signature, step: Step) -> Onset:
        """The onset of a step: among whole spans, then to the minute within those beside the best of them."""
        by_span, from_s = self.gains(step), seen.spans.from_s
        best = likely(by_span, step)
        weight = np.exp((by_span - by_span[best]) / 2.0)
        spread = np.sqrt(weight @ (from_s - weight @ from_s / weight.sum()) ** 2 / weight.sum())
        times, columns = _finer(seen, step, best)
        gain, size, sd = self.judged(columns)
        at = int(np.argmax(gain))
        return Onset(
            step, float(times[at]), float(np.hypot(spread, SLACK_S)), float(size[at]), float(sd[at]),
            float(by_span[best]), columns[:, at],
        )  # fmt: skip

    def judged(self, columns: Array) -> tuple[Array, Array, Array]:
        """Gain, size and sd of each column, (k,)."""
        curvature = np.einsum("nk,nk->k", columns, cho_solve(self._factor, columns))
        slope = columns.T @ self._pull
        seen = curvature > 1e-9
        curvature = np.where(seen, curvature, 1.0)
        return np.where(seen, slope**2 / curvature, 0.0), np.where(seen, slope / curvature, 0.0), curvature**-0.5


def likely(gains: Array, step: Step) -> int:
    """The span with the largest gain; of nearly as large ones one with which a drive begins, for what is changed is
    changed at rest, and what acts only while the screw turns shows from the next drive on."""
    begins = step.acts & ~np.append(False, step.acts[:-1])
    as_good = begins & (gains > NEARLY * gains.max())
    return int(np.argmax(np.where(as_good, gains, 0.0) if as_good.any() else gains))


def _finer(seen: Signature, step: Step, best: int) -> tuple[Array, Array]:
    """Onsets in the span before the best and at its beginning, (k,) s, and their columns (N, k)."""
    from_s, before = seen.spans.from_s, best - 1
    parts = np.arange(1, FINER + 1) / FINER if step.acts[before] else np.ones(1)
    parts = np.append(parts, 1.0 + parts[:-1]) if best + 1 < len(from_s) and step.acts[best + 1] else parts
    whole = np.floor(parts - 1e-9).astype(int)
    at, share = before + whole, parts - whole
    times = from_s[at] + share * (from_s[at + 1] - from_s[at])
    return times, (1.0 - share) * step.columns[:, at] + share * step.columns[:, at + 1]
