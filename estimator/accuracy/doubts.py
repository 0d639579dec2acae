"""Why estimates are to be doubted, in plain sentences: one sensor, the model, or the noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estimator.accuracy.review import Review, overall
from estimator.faults.sentences import place_of
from estimator.rig import Rig

LOUD = 4.0  # a NIS from which on readings are more than twice as far off as the filter expects


def doubts(reviews: Sequence[Review], rig: Rig) -> list[str]:
    """What a NIS far above 1 comes from; and that the model fails, where no sensor is to blame."""
    said = [f"{r.recording.name}: NIS {r.nis_mean:.0f} {_source(r, rig)}" for r in reviews if r.nis_mean > LOUD]
    return said + _worse([one for one in reviews if not (one.use.suspects or (one.nis_mean > LOUD and loudest(one)))])


def loudest(review: Review) -> str:
    """The channel that most of the NIS comes from; none where it comes from several."""
    total = {one.channel: one.used * np.nan_to_num(review.nis_of[one.channel]) for one in review.use.channels}
    most = max(total, key=lambda name: float(total[name]))
    return most if len(total) > 2 and total[most] > 0.5 * sum(total.values()) else ""


def _source(review: Review, rig: Rig) -> str:
    if channel := loudest(review):
        return f"comes from {place_of(rig, rig.index(channel))}: check that sensor first; a fit would follow its error"
    times = f"{np.sqrt(review.nis_mean):.1f} times"
    return f"per channel: readings are {times} as far off as the filter expects; `ballscrew diagnose` says where"


def _worse(reviews: Sequence[Review]) -> list[str]:
    """Said where the model makes the estimate worse than what needs no model."""
    line, ours = overall(reviews, "polyline"), overall(reviews, "filter")
    if not ours.rms_um > line.rms_um:
        return []
    return [
        f"the filter ({ours.rms_um:.2f} um rms) is worse than the polyline ({line.rms_um:.2f}): the model lacks "
        "something, or was fitted to another machine; `ballscrew diagnose` says where, `ballscrew fit` fits it"
    ]
