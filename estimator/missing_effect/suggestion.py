"""What a search for a missing effect found."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from estimator.events.event import Event
from estimator.faults.use import Use
from estimator.hypotheses.hypothesis import Hypothesis
from estimator.missing_effect.begun import Begun
from estimator.missing_effect.wrong_input import Mislabel
from estimator.unknown.composed import Composed
from estimator.unknown.unexplained import Unexplained
from estimator.work import Runs


@dataclass(frozen=True)
class Suggestion:
    """The verdict and what it rests on.

    verdict  "effect", "tie", "effects": two that explain only together, "input_error", "nothing_missing", or
             "nothing_in_catalogue": something unknown explains it (`unexplained`), or nothing does, and the model is
             far off
    found    hypotheses with an effect each, best first; with two, the pair
    tie      names that these recordings cannot tell apart
    as_given, again  the model without them: as it is, give or take what its fit left open; with all fitted again
    before   whichever of these the verdict is held against
    changed  own parameter "effect.param" that alone explains it: of another value on this machine, or in these runs
    pair     two effects together, where they explain clearly more than one
    wrong_input, events  of one run, or what began within it, or either: all else is said of the other recordings
    by_others  the verdict on these
    composed   the effect that something unknown is, fitted in full, where that could be told
    uses     what was used of each recording
    partly   the effect that explains most, and too little of it: the model stays far off
    far      the model is so far off that something is missing
    believed   thermometers that jump in step with the drive, which are heard here and left out elsewhere
    """

    verdict: str
    found: tuple[Hypothesis, ...]
    tie: tuple[str, ...]
    as_given: Hypothesis
    again: Hypothesis
    before: Hypothesis
    uses: tuple[Use, ...]
    changed: str = ""
    pair: tuple[str, ...] = ()
    wrong_input: Mislabel | None = None
    unexplained: Unexplained | None = None
    composed: Composed | None = None
    events: tuple[Event, ...] = ()
    by_others: str = ""
    far: bool = False
    partly: str = ""
    believed: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """The verdict, then what was found: misfit on recordings left out, 1 is a good model's, and parameters."""
        found = [self.before, *self.found, *([self.composed.hypothesis] if self.composed else [])]
        return "\n".join([self.verdict, *(f"  {one}" for one in found)])

    @property
    def apart(self) -> str:
        """The one recording with which something is wrong, that is none of the rest's; "" where there is none."""
        if not self.by_others:
            return ""
        return self.wrong_input.run if self.wrong_input is not None else self.events[0].run

    @property
    def others(self) -> "Suggestion":
        """What the recordings say but for the one apart; all of them, where there is none."""
        if not self.by_others:
            return self
        return replace(self, verdict=self.by_others, by_others="", wrong_input=None, events=())

    def set_apart(self, found: Sequence[Mislabel | Begun]) -> "Suggestion":
        """What the other recordings say, with what may be wrong with the one, the likeliest first."""
        by_others, wrong, said = self.verdict, isinstance(found[0], Mislabel), self
        verdict = "nothing_in_catalogue" if by_others == "nothing_missing" else by_others
        for one in found:
            said = replace(said, wrong_input=one) if isinstance(one, Mislabel) else replace(said, events=one.events)
        return replace(said, verdict="input_error" if wrong else verdict, by_others=by_others)

    def kept(self, runs: Runs) -> Runs:
        """The runs but for the one apart."""
        return replace(runs, recordings=[each for each in runs.recordings if each.name != self.apart])

    @property
    def loosened(self) -> list[str]:
        """Parameters that the model holds fixed and that are others by more than two sd, the furthest first.

        They are so beside the effect that was found, or in the model without any; none where an earlier fit holds.
        """
        best = self.found[0] if self.found and self.verdict in ("effect", "effects", "tie") else self.before
        if not best.refit:
            return []
        here, was = best.known(), self.as_given.ground.model
        fixed = [path for path in best.paths if path in was.values and path not in was.free()]
        off = {path: abs(here[path] - was[path]) / (here.values[path].sd or float("inf")) for path in fixed}
        return sorted((path for path in fixed if off[path] > 2.0), key=lambda path: -off[path])

    @property
    def second(self) -> str:
        """The effect that is missing besides the one that is named, or its rivals; "" where none is."""
        named = self.tie or self.found[0].names if self.verdict in ("effect", "tie") else self.pair
        return next((name for name in self.pair if name not in named), "")

    @property
    def one_recording(self) -> bool:
        """Whether nothing could be left out: all errors are of what was fitted."""
        return len(self.as_given.judged.runs) == 1

    def without(self, h: Hypothesis) -> Hypothesis:
        """What a hypothesis adds its effect to."""
        return self.again if h.refit else self.as_given
