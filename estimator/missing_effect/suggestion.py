"""What a search for a missing effect found, and when a hypothesis counts.

The shares were set on simulated runs with nothing missing, where the best of a hundred candidates leaves 91 % or more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimator.faults.use import Use
from estimator.missing_effect.hypothesis import Hypothesis
from estimator.missing_effect.screening import Screened
from estimator.missing_effect.wrong_input import Mislabel

MATERIAL = 0.89  # an effect leaves at most this share of the misfit, or it is not missing; ...
MATERIAL_REFIT = 0.85  # ... this share where all parameters are fitted again beside it ...
ALONE = 0.5  # the same where there is one recording, and none can be left out
MATERIAL_K, MATERIAL_UM = 0.016, 0.12  # ... and takes at least so much off one of the errors
ALIKE = 1.04  # a misfit within this of the best is as good
GOOD = 1.3  # a misfit that is good enough not to look for what is unknown


@dataclass(frozen=True)
class Suggestion:
    """The verdict and what it rests on.

    verdict  "effect", "tie", "input_error", "nothing_missing", or "nothing_in_catalogue": something unknown explains
             it (`unexplained`), or nothing does, and the model is far off
    found    hypotheses with an effect each, best first;  tie: names that these recordings cannot tell apart
    as_given, again  the model without them, as it is and fitted again
    pair     two effects together, where they explain clearly more than one
    uses     what was used of each recording
    far      the model, with a wrong input set right, is so far off that something is missing
    """

    verdict: str
    found: tuple[Hypothesis, ...]
    tie: tuple[str, ...]
    as_given: Hypothesis
    again: Hypothesis
    uses: tuple[Use, ...]
    pair: tuple[str, ...] = ()
    wrong_input: Mislabel | None = None
    unexplained: Screened | None = None
    far: bool = False

    @property
    def one_recording(self) -> bool:
        """Whether nothing could be left out: all errors are of what was fitted."""
        return len(self.as_given.judged.runs) == 1

    @property
    def before(self) -> Hypothesis:
        """The model without any effect more, as it is or fitted again, whichever predicts better."""
        return min(self.as_given, self.again, key=lambda h: h.misfit)

    def without(self, h: Hypothesis) -> Hypothesis:
        """What a hypothesis adds its effect to."""
        return self.again if h.refit else self.as_given


def alike(h: Hypothesis, best: Hypothesis) -> bool:
    """Whether a hypothesis explains as well as the best one; with all parameters moved it must do better for that."""
    return h.misfit <= (best.misfit if h.refit and not best.refit else ALIKE * best.misfit)


def material(h: Hypothesis, as_given: Hypothesis, again: Hypothesis) -> bool:
    """Whether an effect takes enough off the misfit of the model without it, as it is and fitted again.

    In temperature or in elongation it must be less than either leaves by what can be seen.
    """
    least = MATERIAL if len(h.judged.runs) > 1 else ALONE
    beside = min(least, MATERIAL_REFIT) if h.refit else 0.95
    less = h.misfit <= least * as_given.misfit and h.misfit <= beside * again.misfit
    rivals = (as_given.judged, again.judged)
    heat = min(r.error.temperature_K for r in rivals) ** 2 - h.judged.error.temperature_K**2
    length = np.nan_to_num(min(r.read_um for r in rivals) ** 2 - h.judged.read_um**2)
    return bool(less and (heat > MATERIAL_K**2 or length > MATERIAL_UM**2))
