"""The most likely onset: generalised likelihood ratio over times and places (Willsky & Jones 1976).

    gain = (c' S^-1 y)^2 / (c' S^-1 c),      size = c' S^-1 y / (c' S^-1 c)

twice the log-likelihood that a step c from a time on adds to the pattern S that a model's misfit always has. What ends
again within the run is the difference of two steps.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from estimator.events.carriers import Carrier
from estimator.events.event import DRIVING, HOT, LOOSE, READING
from estimator.events.readings import LEAST
from estimator.events.signature import Signature, without_zeros
from estimator.events.spans import Spans
from estimator.missing_heat.causes import Averages, covariance
from estimator.record import Array
from estimator.sensitivity.objective import GOOD_K, GOOD_UM

FINER = 5  # onsets that are tried within a span
READS_WORSE = 1.5  # times the gain of any heat, from which on a reading is called wrong
NEARLY = 0.9  # of the largest gain
LASTS_S = 600.0  # at least; and so far from a start or a stop what begins or ends does not go with it
ENDS = 50.0  # by how much more likely an end makes it: as much as an onset has to add
LEAST_SEEN, LEAST_SHARE = 1e-9, 1e-3  # curvature of what moves no reading; of a step's, of what begins and ends at once
SHOWS = 2.0  # times what a good model leaves, by which an event moves readings: less is not worth a person's look
SLACK = 1 / 6  # of the least that it lasts, sd of the sharpest onset: simulated ones were off by 70 s (rms), of 600


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
    """The most likely onset of a step: when, how large, and how much it adds; `column` (N,) by 1 of it.

    until_s  when it ended; None: not within the run
    """

    step: Step
    since_s: float
    sd_s: float
    size: float
    sd: float
    gain: float
    column: Array
    until_s: float | None = None


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
        if seen.trial.rig.is_thermometer[channel]:
            yield _step(LOOSE, None, own * seen.rise[:, None], seen.trial.rig.names[channel])


def _step(kind: str, carrier: Carrier | None, moves: Array, channel: str | None = None) -> Step:
    from_there = np.cumsum(moves[:, ::-1], axis=1)[:, ::-1]
    return Step(kind, carrier, channel, from_there, np.abs(moves).max(axis=0) > 0)


def best_onset(seen: Signature, measured: Averages, sizes: Mapping[str, float], tried: Sequence[Step]) -> Onset | None:
    """Of all steps; a reading only where no heat explains nearly as much. None where nothing can have begun."""
    solver = Solver(measured, sizes)
    found = [(solver.gain(seen, step), step) for step in tried]
    heat, reads = (
        max((one for one in found if (one[1].carrier is None) is of_readings), default=None, key=lambda one: one[0])
        for of_readings in (False, True)
    )
    best = heat if reads is None or (heat and reads[0] <= READS_WORSE * heat[0]) else reads
    return solver.onset(seen, best[1]) if best and best[0] > 0.0 else None


def worth(onset: Onset, seen: Signature) -> bool:
    """Whether it moves the thermometers, or the displacement, by more than a good model leaves, rms over the run.

    Of what is wrong with one thermometer that one alone counts.
    """
    moved = onset.size * onset.column
    heat = seen.trial.rig.is_thermometer[seen.channel]
    shown = heat if onset.step.carrier is not None else heat & (moved != 0)
    families = ((shown, GOOD_K), (~heat, GOOD_UM))
    return any(rows.any() and (moved[rows] ** 2).mean() > (SHOWS * good) ** 2 for rows, good in families)


class Solver:
    """A recording's averages under a pattern; lasts_s: what ends again lasts so long, at least and at most."""

    def __init__(
        self, measured: Averages, sizes: Mapping[str, float], lasts_s: tuple[float, float] = (LASTS_S, np.inf)
    ) -> None:
        self._lasts_s = lasts_s
        self._factor = scipy.linalg.cho_factor(covariance(measured, sizes))
        self._pull = scipy.linalg.cho_solve(self._factor, measured.y)

    def gain(self, seen: Signature, step: Step) -> float:
        """The most that any onset of a step adds, less what an end must add where that makes it more."""
        once, ended = self.gains(seen, step)
        return float(max(once.max(), ended.max() - ENDS))

    def gains(self, seen: Signature, step: Step) -> tuple[Array, Array]:
        """Of onsets with each span to the end, (B,), and until another span, (B, B).

        With the first in which it acts nothing begins: it always was there. Heat may end; a thermometer stays
        wrong, and what acts in drives alone ends with each.
        """
        slope, K = self._products(step.columns)
        own, spans = np.diag(K), np.arange(len(slope))
        may = step.acts & (spans > (np.flatnonzero(step.acts)[0] if step.acts.any() else len(spans)))
        if step.kind == LOOSE:
            may &= (slope < -LEAST * own) & (slope >= -own)
        once = np.where(may, _over(slope, own), 0.0)
        apart, both = slope[:, None] - slope, own[:, None] + own - 2.0 * K
        ends = may[:, None] & _may_end(seen.spans, *self._lasts_s) & (step.carrier is not None and step.acts.all())
        return once, np.where(ends & (both > LEAST_SHARE * own[:, None]), _over(apart, both), 0.0)

    def onset(self, seen: Signature, step: Step) -> Onset:
        """The onset of a step: among whole spans, then to the minute within those beside the best of them."""
        by_span, ended = self.gains(seen, step)
        end = None
        if ended.max() - ENDS > by_span.max():
            end = int(ended.max(axis=0).argmax())
            by_span = ended[:, end]
        best, from_s = likely(by_span, step), seen.spans.from_s
        weight = np.exp((by_span - by_span[best]) / 2.0)
        spread = np.sqrt(weight @ (from_s - weight @ from_s / weight.sum()) ** 2 / weight.sum())
        since_s, until_s, column = self._finely(seen, step, best, end)
        _, size, sd = (float(values[0]) for values in self.judged(column[:, None]))
        sd_s, gain = float(np.hypot(spread, SLACK * self._lasts_s[0])), float(by_span[best])
        return Onset(step, since_s, sd_s, size, sd, gain, column, until_s)

    def _finely(self, seen: Signature, step: Step, best: int, end: int | None) -> tuple[float, float | None, Array]:
        """When it began and ended, to a part of the spans, at least half as long after as it has to last."""
        times, columns = _finer(seen, step, best)
        if end is None:
            since_s, column = self._finest(times, columns, 0.0)
            return since_s, None, column
        soon, after = times <= seen.spans.from_s[end] - self._lasts_s[0] / 2, step.columns[:, end]
        since_s, column = self._finest(times[soon], columns[:, soon], -after)
        times, columns = _finer(seen, step, end)
        late = times >= since_s + self._lasts_s[0] / 2
        until_s, column = self._finest(times[late], columns[:, late], -(column + after), -1.0)
        return since_s, until_s, column

    def _finest(self, times: Array, columns: Array, beside: Array | float, sign: float = 1.0) -> tuple[float, Array]:
        """The time at which a step adds most, beside what began or ended at another; and sign times both."""
        both = sign * (columns + np.reshape(beside, (-1, 1)))
        at = int(np.argmax(self.judged(both)[0]))
        return float(times[at]), both[:, at]

    def judged(self, columns: Array) -> tuple[Array, Array, Array]:
        """Gain, size and sd of each column, (k,)."""
        slope, K = self._products(columns)
        curvature = np.where(np.diag(K) > LEAST_SEEN, np.diag(K), 1.0)
        seen = np.diag(K) > LEAST_SEEN
        return _over(slope, np.diag(K)), np.where(seen, slope / curvature, 0.0), curvature**-0.5

    def _products(self, columns: Array) -> tuple[Array, Array]:
        """c' S^-1 y, (k,), and c' S^-1 c, (k, k), of columns (N, k)."""
        return columns.T @ self._pull, columns.T @ scipy.linalg.cho_solve(self._factor, columns)


def _may_end(spans: Spans, least_s: float, most_s: float) -> Array:
    """What may begin with a span and end with another, (B, B): it lasts, and does not go with the motion.

    Heat from some start to some stop is the model's.
    """
    from_s, turned = spans.from_s, spans.from_s[1:][np.diff(spans.drive)]
    near = np.array([np.abs(turned - at).min(initial=np.inf) < least_s for at in from_s])
    lasts_s = from_s - from_s[:, None]
    return np.asarray((lasts_s >= least_s) & (lasts_s <= most_s) & ~(near & near[:, None]))


def _over(slope: Array, curvature: Array) -> Array:
    """Gains; none of what moves no reading."""
    return np.divide(slope**2, curvature, out=np.zeros_like(slope), where=curvature > LEAST_SEEN)


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
