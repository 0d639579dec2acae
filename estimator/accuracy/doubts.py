"""Why estimates are to be doubted, in plain sentences: one sensor, the model, or the noise."""

from collections.abc import Sequence

import numpy as np

from estimator.accuracy.machine import LIMIT_SD
from estimator.accuracy.review import Review, overall
from estimator.faults.sentences import place_of
from estimator.faults.use import MUTED
from estimator.inputs.untold import gaps_s
from estimator.rig import Rig

LOUD = 4.0  # a NIS from which on readings are more than twice as far off as the filter expects
ALONE, OTHERS = 9.0, 3.0  # that of one channel, and so many times that of most others


def doubts(reviews: Sequence[Review], rig: Rig) -> list[str]:
    """What a NIS far above 1 comes from; and that the model fails, where no sensor is to blame, nor another machine."""
    untold = {r.recording.name: gaps for r in reviews if (gaps := gaps_s(r.recording, rig))}
    said = [f"{name}: {_untold(gaps, rig)}" for name, gaps in untold.items()]
    others = [r for r in reviews if r.recording.name not in untold]
    said += [f"{r.recording.name}: {sentence}" for r in others if (sentence := _loud(r, rig))]
    return said + _worse([one for one in others if _by_model(one)])


def loudest(review: Review) -> str:
    """The channel whose readings alone are far further off than expected; none where those of most are."""
    nis = {name: value for name, value in review.nis_of.items() if np.isfinite(value)}
    most = max(nis, key=lambda name: nis[name], default="")
    return most if most and nis[most] > max(ALONE, OTHERS * float(np.median(list(nis.values())))) else ""


def _untold(gaps: Sequence[tuple[float, float]], rig: Rig) -> str:
    """Said where the model alone cannot be right."""
    spans = ", ".join(f"{begin:.0f} to {end:.0f} s" for begin, end in gaps)
    what = "the drive was not told" if "speed" in rig.inputs else "nothing was read"
    return f"{what} from {spans}: what the machine did then is not known, and the model alone is off from there on"


def _loud(review: Review, rig: Rig) -> str:
    if channel := loudest(review):
        at = place_of(rig, rig.index(channel))
        return f"NIS {review.nis_of[channel]:.0f} of {at}: check that sensor first; a fit would follow its error"
    if not review.nis_mean > LOUD:
        return ""
    off = f"readings are {np.sqrt(review.nis_mean):.1f} times as far off as the filter expects"
    return f"NIS {review.nis_mean:.0f}: {off}; `ballscrew diagnose` says where"


def _by_model(review: Review) -> bool:
    """Whether nothing but the model would make the estimate worse than a polyline: no sensor, no input that
    failed, no other machine, and no silence of a thermometer that the polyline goes on to see."""
    use = review.use
    silenced = any(0 < one.why.get(MUTED, 0) < one.taken for one in use.channels)
    failed = use.suspects or use.inputs or use.travel or loudest(review)
    return not (silenced or failed or review.off_sd > LIMIT_SD)


def _worse(reviews: Sequence[Review]) -> list[str]:
    """Said where the model makes the estimate worse than what needs no model."""
    line, ours = overall(reviews, "polyline"), overall(reviews, "filter")
    if not ours.rms_um > line.rms_um:
        return []
    return [
        f"the filter ({ours.rms_um:.2f} um rms) is worse than the polyline ({line.rms_um:.2f}): the model lacks "
        "something; `ballscrew diagnose` says where"
    ]
