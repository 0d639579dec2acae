"""What a search has left open, as hypotheses that a run must set apart."""

from __future__ import annotations

from dataclasses import dataclass

from estimator.batch.trials import Trials
from estimator.hypotheses.candidates import Candidate
from estimator.hypotheses.criterion import APART_SE, worth
from estimator.hypotheses.hypothesis import Hypothesis, refined
from estimator.missing_effect.stand_ins import unknown_of
from estimator.missing_effect.suggestion import Suggestion
from estimator.missing_effect.unexplained import Unexplained
from estimator.rig import Rig

ALONE = "the model alone"
MOST = 4  # stand-ins that one run is asked to set apart


@dataclass(frozen=True)
class Question:
    """The best hypothesis and those to be told from it, each with its name; the first of them is the best.

    why   "tie", "pair", "unexplained", "partly", "one recording", "not proven", "badly known"
    path  the parameter "effect.param" of the best that is badly known, where that is the question
    """

    why: str
    rivals: tuple[tuple[str, Hypothesis], ...]
    path: str = ""


def question(found: Suggestion, trials: Trials) -> Question | None:
    """What is open; None where nothing is, or where a run is to be checked first.

    trials  the recordings that were searched in
    """
    if found.verdict == "tie":
        tied = {h.names[0]: h for h in reversed(found.found) if h.names[0] in found.tie}
        return Question("tie", tuple((name, tied[name]) for name in found.tie))
    if found.verdict == "effects":
        return _pair(found)
    if found.unexplained is not None and found.verdict == "nothing_in_catalogue":
        return _unknown(found.unexplained, found, trials)
    if found.verdict == "input_error" or found.changed or not found.found:
        return None
    return _of_the_best(found)


def _of_the_best(found: Suggestion) -> Question | None:
    """What is open of the best effect: whether it is there, or how large it is."""
    best = found.found[0]
    alone = ((best.names[0], best), (ALONE, found.before))
    if found.verdict == "effect" and not found.one_recording:
        path = badly_known(best)
        return Question("badly known", alone[:1], path) if path else None
    if best.misfit >= found.before.misfit:
        return None
    if found.verdict == "nothing_in_catalogue":
        return Question("partly", alone)
    if found.one_recording:
        return Question("one recording", alone)
    return Question("not proven", alone) if worth(best, found.before.judged) else None


def badly_known(h: Hypothesis) -> str:
    """The parameter of an effect that is known worst, if it is within two sd of nothing; "" if none is."""
    own = {path: v for path, v in h.own().items() if v.sd and not v.fixed and h.model.param(path).over == ""}
    unsure = {path: v.sd / max(abs(v.value - (h.model.param(path).null or 0.0)), 1e-12) for path, v in own.items()}
    worst = max(unsure, key=lambda path: unsure[path], default="")
    return worst if worst and unsure[worst] > 1 / APART_SE else ""


def _pair(found: Suggestion) -> Question:
    """Both against either alone, where that was fitted; else against none."""
    pair = found.found[0]
    singles = [(h.names[0], h) for h in found.found[1:] if len(h.names) == 1 and h.names[0] in pair.names]
    return Question("pair", ((" and ".join(pair.names), pair), *(singles or [(ALONE, found.before)])))


def _unknown(unknown: Unexplained, found: Suggestion, trials: Trials) -> Question | None:
    """The stand-in against others that explain as much, fitted in full; by one recording against none."""
    ground, rig = unknown.hypothesis.ground, trials[0].rig
    best = (_words(unknown.candidate, rig), unknown.hypothesis)
    rivals = [
        (_words(rival.candidate, rig), refined(ground, trials, [rival.candidate], rival.first))
        for rival in unknown.rivals[: MOST - 1]
    ]
    if rivals:
        return Question("unexplained", (best, *rivals))
    return Question("one recording", (best, (ALONE, found.before))) if found.one_recording else None


def _words(candidate: Candidate, rig: Rig) -> str:
    unknown = unknown_of(candidate, rig)
    return f"{unknown.what} that follows {unknown.follower.words}"
