"""When a hypothesis counts, and when two cannot be told apart."""

import numpy as np
import scipy

from estimator.hypotheses.hypothesis import Hypothesis
from estimator.hypotheses.panel import Explanation
from estimator.record import Array

CHANCE = 0.05  # the share of searches in which something may be named although nothing is missing
APART_SE = 2.0  # standard errors between what can be told apart
WORTH_K, WORTH_UM = 0.016, 0.12  # an effect takes at least so much off one of the errors: a third of a good model's
PROMISE = 4.0  # times less than the screen says may be left of a misfit once an effect is fitted in full
ROUNDING = 1e-9  # of a misfit: nearer are the same but for the processor's rounding
MOST = 0.5  # of a misfit: what takes less off is not what is missing while the model stays far off
GOOD = 1.3  # a misfit that is good enough not to look for what is unknown: what its own scatter over recordings allows


def clearly(before: Explanation, after: Explanation, tried: float) -> bool:
    """Whether the best of so many explanations leaves so much less that it is no chance.

        n / 2  ln(before / after)  >  ln(tried / CHANCE)

    the logarithm of the likelihood ratio of n independent readings whose scatter is not known, against a bound on the
    chance that any of `tried` reaches it (Bonferroni); it scales with the recordings and with the catalogue. Where the
    one recording was fitted too, every parameter costs ln(n) / 2 more (Schwarz 1978).
    """
    more = len(after.chosen) - len(before.chosen)
    fitted = 0.5 * more * np.log(after.weight) if len(after.runs) == 1 else 0.0
    return bool(nats(before, after) > np.log(tried / CHANCE) + fitted)


def nats(a: Explanation, b: Explanation) -> float:
    """By how much the second is likelier, left-out recordings alone."""
    return _nats(b.weight, a.misfit, b.misfit)


def _nats(weight: float, before: float, after: float) -> float:
    return 0.5 * weight * float(np.log(max(before, 1e-12) / max(after, 1e-12)))


def behind(a: Explanation, best: Explanation) -> float:
    """Standard errors by which one leaves more than another: of the difference in each block (`Trial.block_s`)."""
    if abs(a.misfit - best.misfit) <= ROUNDING * best.misfit:
        return 0.0
    apart = (a.blocks - best.blocks).sum(axis=0)
    return (a.misfit - best.misfit) / _error_of(apart, best)


def alike(a: Explanation, best: Explanation, tried: int) -> bool:
    """Whether recordings cannot tell the best of `tried` explanations from another, by blocks or by all together."""
    if clearly(a, best, tried):
        return False
    return behind(a, best) < APART_SE or not clearly(a, best, 1)


def most(before: Explanation, after: Explanation) -> bool:
    """Whether it takes most of the misfit off."""
    return after.misfit <= (1.0 - MOST) * before.misfit


def material(h: Hypothesis, before: Explanation, tried: int) -> bool:
    """Whether an effect is missing: it is proven, and worth having."""
    return proven(before, h.judged, tried) and worth(h, before)


def proven(before: Explanation, after: Explanation, tried: float) -> bool:
    """Whether the best of so many leaves clearly less of recordings left out, and is itself seen in all of them.

        n ln(before / after) > chi2(k)      misfits of all recordings, which were fitted; k: parameters more

    What is not is of no sure size: it only holds the model's own parameters, which a few recordings tell badly, nearer
    to what suits the one left out. From how many it was chosen is asked of those left out.
    """
    more = max(1, len(after.chosen) - len(before.chosen))
    seen = 2.0 * _nats(after.weight, before.fitted, after.fitted) > scipy.special.chdtri(more, CHANCE)
    return bool(seen) and clearly(before, after, tried)


def worth(h: Hypothesis, before: Explanation) -> bool:
    """Whether an effect, if it is there, is worth having: it is of a size that can be.

    In temperature or in elongation it must take something off that can be seen, and make the elongation no worse. What
    readings lose while the screw turns counts only as far as the elongation, the rests in it, loses it too.
    """
    worse = (h.judged.blocks - before.blocks)[1]
    if h.at_bound() or worse.sum() > APART_SE * _error_of(worse, before):
        return False
    was, left = before.error, h.judged.error
    heat, grown = was.temperature_K**2 - left.temperature_K**2, was.elongation_um**2 - left.elongation_um**2
    length = np.nan_to_num(np.minimum(grown, before.read_um**2 - h.judged.read_um**2))
    return bool(heat > WORTH_K**2 or length > WORTH_UM**2)


def _error_of(apart: Array, one: Explanation) -> float:
    """Standard error of the sum of differences (runs, blocks), of which those after a recording's end are none."""
    known = one.blocks.any(axis=0)
    return float(np.sqrt(known.sum()) * apart[known].std(ddof=1)) if known.sum() > 1 else float("inf")
