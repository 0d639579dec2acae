"""Whether the machine is the model's: by which share of their values the model's parameters must be off.

A bank of filters (Magill 1965) carries what a run has told of the errors d of the parameters, one for each share s by
which they may be off beside what a fit has left open:

    d ~ N(0, C + s^2 W^2)    C covariance of the fit; W what each parameter is, or how wide its table, the larger one
    y = D d + e              y reading less model alone, since the first one; D how it moves with d
    e <- r e + w             what no parameter explains: of minutes, r = exp(-t / 300 s), as large as a second ahead has
                             been unsure in the last quarter of an hour, and at least as what models lack in detail

Each share has the weight that it began with times its likelihood, and the root of their mean square is that of the run.
As many filters again take the position of the table for told with another zero: d has one element more, of 100 mm,
which moves readings only since the screw has turned. The thermometer that the likeliest of them explains worst is not
heard, nor the one that departs most from the others (beside/windows.py): one may be broken.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from estimator.faults.fault import LED_SDS, Led, Seen
from estimator.record import Array

SHARES = np.array([0.0, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2])
ANOTHER = 0.25  # what weighs another machine than the model's before anything is seen
DETAILS_PER_S = 1 / 250  # of log-likelihood: so much another share, or place, gains by what models lack in detail
LASTS_S, UNSURE_S = 300.0, 1000.0  # misfits; what the filter is unsure of after a drive
RENEWED_S, LEFT = 36000.0, 1e-3  # then parameters may have become others; least weight that a share begins again with
DETAILS = {True: 0.03, False: 0.2}  # K of a thermometer, um of a length
OUTLYING = 3.0  # sd, from which on the worst thermometer is not heard
YOUNG_S, LOOK_S = 600.0, 30.0  # how old a run is that is looked at with each block; how often an older one is
LEAST = 0.005  # a smaller share makes no difference
ELSEWHERE = 0.02  # what weighs another place of the nut's heat at first
LEAST_ODDS, SURE = -10.0, 40.0  # logarithms of its odds: least, and from which on it is told
PLACE_MM, WALK_MM2_S = 100.0, 0.5  # by how much it may be another, and become so
SHIFT_SDS, SHIFT_MM, IN_A_ROW = 3.0, 15.0, 3  # least that is told, by so many looks
STILL_SDS, STILL_MM, LASTING = 1.0, 5.0, 20  # least that goes on being told, and looks for which less does not end it


@dataclass(frozen=True)
class Known:
    """How well p parameters are known: root root' the covariance (p, p) of their errors; whole (p,) what each of them
    is, or how wide its table is, whichever is more; 0: it is no other on another machine. The one number `shift` is by
    which the position is told with another zero, mm: nothing, unless the thermometers say so."""

    root: Array
    whole: Array
    shift: int | None = None

    def apart(self, led: Led, share: float, place_mm: float) -> Array:
        """Whether lengths have led further than thermometers allow, (K,), where parameters are off by a share, and the
        nut's heat may stand elsewhere by so much.

        Never by a model of which nothing says how good it is.
        """
        if not self.whole.any():
            return np.zeros(len(led), dtype=bool)
        if not led.far.any():
            return led.far
        place_um = 0.0 if self.shift is None else place_mm * led.doubt[:, self.shift]
        sd_um = led.worse * np.sqrt(self.elongation_var(led, np.full(len(led), share)) + place_um**2)
        return np.asarray(led.far & (np.abs(led.um) > LED_SDS * sd_um))

    def elongation_var(self, led: Led, share: Array) -> Array:
        """Of the elongation by thermometers alone, (K,) um^2, where parameters are off by shares (K,)."""
        return np.asarray(led.var + (self.doubtful(led.doubt, share) ** 2).sum(axis=1))

    def doubtful(self, moved: Array, share: Array) -> Array:
        """What moves with parameters by `moved` (K, ..., p) is off by, where they are off by shares (K,) of themselves.

        Per standard normal error: of the fit, and where any share is not 0, of each parameter beside it
        """
        at, q, p = np.flatnonzero(self.whole * share.any()), self._together, len(self.whole)
        doubt = np.empty((*moved.shape[:-1], p + len(at)))
        np.matmul(moved[..., :q], self.root[:q, :q], out=doubt[..., :q])
        np.multiply(moved[..., q:], np.diagonal(self.root)[q:], out=doubt[..., q:p])
        if len(at):
            by = share.reshape(-1, *[1] * (moved.ndim - 1))
            np.multiply(np.take(moved, at, axis=-1), by * self.whole[at], out=doubt[..., p:])
        return doubt

    @cached_property
    def _together(self) -> int:
        """How many parameters, from the first one on, a fit has left unknown together; each other one by itself."""
        alone = self.root - np.diag(np.diagonal(self.root)) == 0.0
        return int(np.flatnonzero(~(alone.all(axis=0) & alone.all(axis=1))).max(initial=-1)) + 1


@dataclass
class Look:
    """The last reading of each channel that was used since the look before, (m, ...); NaN: none was."""

    y: Array
    moved: Array
    variance: Array

    @classmethod
    def none(cls, m: int, p: int) -> "Look":
        """No reading of any channel."""
        return cls(np.full(m, np.nan), np.zeros((m, p)), np.zeros(m))

    def hear(self, y: Array, moved: Array, sd: Array) -> None:
        """Take ticks, each (k, m, ...): misfit, NaN where it was not used, how that moves, sd of the innovation."""
        read = np.isfinite(y)
        some = np.flatnonzero(read.any(axis=0))
        last = len(y) - 1 - np.argmax(read[::-1, some], axis=0), some
        self.y[some], self.moved[some], self.variance[some] = y[last], moved[last], sd[last] ** 2
        self.variance[np.isnan(self.y)] = sd[-1, np.isnan(self.y)] ** 2

    def less(self, other: "Look", by: Array | float = 1.0) -> tuple[Array, Array]:
        """Misfit (m,) and how it moves (m, p), less a part of those of another look."""
        by = np.broadcast_to(by, self.y.shape)
        return self.y - by * other.y, self.moved - by[:, None] * other.moved


class Machine:
    """What one run has told of its model's parameters, look after look; `share` is by which they are off.

    shift_mm  by how much the nut's heat stands elsewhere than the position says, 0: the thermometers do not say so
    place_mm  by how much it may
    """

    def __init__(self, known: Known, heat: Array, tick_s: float) -> None:
        """heat (m,) bool, which channels are thermometers."""
        self._heat, self._tick_s = heat, tick_s
        self._told, self._shift = known.whole.any(), known.shift
        places = 1 if known.shift is None else 2
        self._shares = np.tile(SHARES, places)
        self._shifted = np.arange(len(self._shares)) >= len(SHARES)
        self._prior = known.root @ known.root.T + self._shares[:, None, None] ** 2 * np.diag(known.whole**2)
        if known.shift is not None:
            self._prior[self._shifted, known.shift, known.shift] = PLACE_MM**2
        self._P, self._d = self._prior.copy(), np.zeros(self._prior.shape[:2])
        weight = np.where(self._shares > 0.0, ANOTHER / (len(SHARES) - 1), 1.0 - ANOTHER)
        weight *= np.where(self._shifted, ELSEWHERE, 1.0 - ELSEWHERE if places > 1 else 1.0)
        self._first_log, self._log = np.log(weight), np.zeros(len(weight))
        self._details = np.where(heat, DETAILS[True], DETAILS[False]) ** 2
        m, p = len(heat), len(known.whole)
        self._zero, self._now, self._heard = Look.none(m, p), Look.none(m, p), False
        self._last, self._age_s, self._unsure = Look(np.zeros(m), np.zeros((m, p)), np.zeros(m)), 0.0 * heat, 0.0 * heat
        self._weight, self._learnt_s, self._waited_s = weight, 0.0, 0.0
        self._times, self.shift_mm, self.place_mm, self._rested = 0, 0.0, 0.0, np.zeros(m)

    @property
    def share(self) -> float:
        """By which share of their values the parameters are off, 0: they are as the fit says."""
        share = float(np.sqrt(self._weight @ self._shares**2)) if self._told else 0.0
        return share if share >= LEAST else 0.0

    def hear(self, seen: Seen, some: slice, used: Array) -> None:
        """Take some ticks, of which readings `used` (k, m) are believed."""
        if self._told:
            y = np.where(used, seen.reading[some] - seen.alone[some], np.nan)
            self._now.hear(y, self._since_driven(seen.doubt[some], seen.driven[some]), seen.sd[some])
            self._heard = True

    def _since_driven(self, moved: Array, driven: Array) -> Array:
        """How misfits move (k, m, p), by the position only since the screw has turned: no position of this run says
        where the heat was brought with which it began."""
        if self._shift is None:
            return moved
        moved = moved.copy()
        place = moved[..., self._shift]
        self._rested = place[~driven][-1] if not driven.all() else self._rested
        place -= np.where(driven[:, None], self._rested, place)
        return moved

    def forget(self, i: int) -> None:
        """Channel i has another zero from now on."""
        self._zero.y[i] = np.nan
        self._new()

    def block(self, ticks: int) -> None:
        """The end of a block of so many ticks: learn from what was taken, if it is time to."""
        self._waited_s += ticks * self._tick_s
        if self._heard and (self._learnt_s < YOUNG_S or self._waited_s >= LOOK_S):
            passed_s, self._waited_s = self._waited_s, 0.0
            self._look(self._now, passed_s)
            self._new()

    def _new(self) -> None:
        """The next look begins."""
        self._now, self._heard = Look.none(*self._now.moved.shape), False

    def _look(self, now: Look, passed_s: float) -> None:
        """Learn from a look, so long after the last one."""
        self._age_s += passed_s
        self._learnt_s += passed_s
        if self._learnt_s > RENEWED_S:
            self._renew()
        first = np.isnan(self._zero.y) & np.isfinite(now.y)
        self._begin(now, first)
        self._unsure = np.maximum(
            np.where(np.isfinite(now.variance), now.variance, 0.0), np.exp(-passed_s / UNSURE_S) * self._unsure
        )
        self._log -= DETAILS_PER_S * passed_s * ((self._shares > 0.0) + 1.0 * self._shifted)
        if self._shift is not None:
            self._P[self._shifted, self._shift, self._shift] += WALK_MM2_S * passed_s
        y, moved = now.less(self._zero)
        heard = np.flatnonzero(self._believed(y, moved) & ~first)
        if len(heard):
            self._learn(Look(y, moved, self._unsure + self._details), heard)
        log = self._first_log + self._log
        weight = np.exp(log - log.max())
        self._weight = weight / weight.sum()
        if self._shift is not None:
            self._place(log, self._shift)

    def _place(self, log: Array, k: int) -> None:
        """Whether the nut's heat stands elsewhere, by what those filters say together in which parameter k moves it."""
        here, there = (np.logaddexp.reduce(log[so]) for so in (~self._shifted, self._shifted))
        odds, weight = float(there - here), np.exp(log[self._shifted] - there)
        self._log[self._shifted] += max(0.0, LEAST_ODDS - odds)  # it may become another
        d, var = self._d[self._shifted, k], self._P[self._shifted, k, k]
        mean, square = float(weight @ d), float(weight @ (var + d**2))
        self.place_mm = float(np.sqrt(square / (1.0 + np.exp(-max(odds, LEAST_ODDS)))))
        sds, least_mm = (STILL_SDS, STILL_MM) if self.shift_mm else (SHIFT_SDS, SHIFT_MM)
        sure = odds > SURE and abs(mean) > max(sds * np.sqrt(square - mean**2), least_mm)
        if sure:
            self._times = min(self._times + 1, LASTING)
        else:
            self._times = max(self._times - 1, 0) if self.shift_mm else 0
        self.shift_mm = mean if self._times >= (1 if self.shift_mm else IN_A_ROW) else 0.0

    def _begin(self, now: Look, which: Array) -> None:
        """The misfit of channels counts from now on."""
        for new, zero, last in zip(vars(now).values(), vars(self._zero).values(), vars(self._last).values()):
            zero[which], last[which] = new[which], 0.0
        self._age_s[which] = 0.0

    def _renew(self) -> None:
        """Learn the parameters anew, with the weights that shares have by now."""
        self._P[:], self._d[:], self._learnt_s = self._prior, 0.0, 0.0
        self._first_log, self._log = np.log(np.maximum(self._weight, LEFT)), np.zeros_like(self._log)
        self._age_s[:] = np.inf  # what was heard last says nothing of them

    def _believed(self, y: Array, moved: Array) -> Array:
        """Channels (m,) that were read, but for the thermometer that is furthest off, if far, wherever the nut is."""
        off, log = np.full(len(y), np.inf), self._first_log + self._log
        for so in (~self._shifted, self._shifted) if self._shift is not None else (~self._shifted,):
            best = int(np.argmax(np.where(so, log, -np.inf)))
            variance = self._unsure + self._details + ((moved @ self._P[best]) * moved).sum(axis=1)
            off = np.minimum(off, np.where(self._heat, np.nan_to_num((y - moved @ self._d[best]) ** 2 / variance), 0.0))
        return np.asarray(np.isfinite(y) & ((off < OUTLYING**2) | (off < off.max())))

    def _learn(self, now: Look, heard: Array) -> None:
        """Update every filter of the bank by what has changed since each of the channels (k,) was heard last."""
        r = np.exp(-self._age_s / LASTS_S)
        y, D = (each[heard] for each in now.less(self._last, r))
        PD = self._P @ D.T
        root = np.linalg.cholesky(D @ PD + np.diag((now.variance * (1.0 - r**2))[heard]))
        white = np.linalg.inv(root)  # to solve for as many columns as there are parameters takes three times as long
        K, e = white @ PD.mT, white @ (y - self._d @ D.T)[..., None]
        self._d += (K.mT @ e)[..., 0]
        self._P -= K.mT @ K
        self._log -= np.log(np.diagonal(root, axis1=1, axis2=2)).sum(axis=1) + 0.5 * (e[..., 0] ** 2).sum(axis=1)
        self._last.y[heard], self._last.moved[heard], self._age_s[heard] = now.y[heard], now.moved[heard], 0.0
