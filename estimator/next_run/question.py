"""What a search has left open, as hypotheses that a run must set apart."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from estimator.batch.trials import Trials
from estimator.hypotheses.criterion import APART_SE, worth
from estimator.hypotheses.hypothesis import Hypothesis, refined
from estimator.missing_effect.suggestion import Suggestion
from estimator.rig import Rig
from estimator.unknown.stand_ins import Unknown, unknown_of
from estimator.unknown.unexplained import Unexplained

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


def question(found: Suggestion, rig: Rig, ready: Callable[[], Trials]) -> Question | None:
    """What is open; None where nothing is, or where a run is to be checked first.

    ready  gives the recordings that were searched in, made ready
    """
    if found.verdict == "tie":
        tied = {h.names[0]: h for h in reversed(found.found) if h.names[0] in found.tie}
        return Question("tie", tuple((name, tied[name]) for name in found.tie))
    if found.verdict == "effects":
        return _pair(found)
    if found.unexplained is not None and found.verdict == "nothing_in_catalogue":
        return _unknown(found.unexplained, found, rig, ready)
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


def _unknown(
    unknown: Unexplained, found: Suggestion, rig: Rig, ready: Callable[[], Trials]
) -> Question | None:  # fmt: skip
    """The stand-in against others that explain as much, fitted in full; by one recording against none."""
    some = unknown.rivals[: MOST - 1]
    seats = [unknown.candidate, *(rival.candidate for rival in some)]
    best, *names = _words([unknown_of(seat, rig) for seat in seats])
    if some:
        ground, trials = unknown.hypothesis.ground, ready()
        fitted = [refined(ground, trials, [rival.candidate], rival.first) for rival in some]
        return Question("unexplained", ((best, unknown.hypothesis), *zip(names, fitted, strict=True)))
    alone = ((best, unknown.hypothesis), (ALONE, found.before))
    return Question("one recording", alone) if found.one_recording else None


def _words(unknown: Sequence[Unknown]) -> list[str]:
    """What each follows; with its place, where these are several."""
    if len({one.what for one in unknown}) == 1 < len(unknown):
        return [one.follower.words for one in unknown]
    return [f"{one.what} that follows {one.follower.words}" for one in unknown]
