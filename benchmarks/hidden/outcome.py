"""What came out of a case, as facts that a line of JSON holds; whether that is right is judged elsewhere."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from benchmarks.hidden.plants import OWN
from estimator.accuracy.noise_floor import Error
from estimator.faults.use import Use
from estimator.missing_effect.improve import Improvement
from estimator.missing_effect.suggestion import Suggestion
from estimator.model import Model
from estimator.rig import Rig
from estimator.unknown.composed import Composed
from estimator.unknown.stand_ins import unknown_of

PATHS = sorted({path for paths in OWN.values() for path in paths})
NAMING = ("effect", "tie", "effects")  # verdicts that name effects


@dataclass
class Outcome:
    """Of one case. Errors are (K, um), open loop, on the runs held out.

    said      effects that are named, best first; by `improve` all that it added, and their ties
    own       effects that the model has of which a parameter is said to be another one now, alone or in a tie
    values    by path, of parameters that may be a planted effect under another name, in each model that the verdict
              leaves: those with what is said, or the model without any effect more
    held      values of such parameters that the model has fixed, or has not (0)
    place_mm, follows, channel  of what is in no catalogue;   as_well: what it may follow as well
    composed  names of effects that were composed of it;   misread: of those of a reading, channel and what it follows
    wrong     (run, signal) of an input that is said to be wrong;   shift_mm: by which a position is
    faulty    (run, channel) of thermometers that are said to be broken or suspected
    began     (run, s since its first sample, kind) of what is told to begin within a run
    broken    the (run, channel) that is;   happened: the (run, s) of what does begin
    before, after, knowing  without what is said, with it, and of a model that knows what is planted and was fitted
    search_s  of the processor, for `suggest` or `improve`;   seconds: for the whole case
    error     instead of all this: what was raised
    """

    verdict: str = ""
    said: Sequence[str] = ()
    own: Sequence[str] = ()
    values: Mapping[str, Sequence[float]] = field(default_factory=dict)
    held: Mapping[str, float] = field(default_factory=dict)
    place_mm: float | None = None
    follows: str = ""
    channel: str = ""
    as_well: Sequence[str] = ()
    composed: Sequence[str] = ()
    misread: Sequence[Sequence[str]] = ()
    wrong: Sequence[str] = ()
    shift_mm: float = 0.0
    faulty: Sequence[Sequence[str]] = ()
    began: Sequence[tuple[str, float, str]] = ()
    broken: Sequence[str] = ()
    happened: tuple[str, float] | None = None
    before: Sequence[float] = ()
    after: Sequence[float] = ()
    knowing: Sequence[float] = ()
    search_s: float = 0.0
    seconds: float = 0.0
    error: str = ""

    @property
    def first(self) -> str:
        """The best of what is named; "" if nothing is."""
        return self.said[0] if self.said else ""


def of_suggestion(found: Suggestion, model: Model, rig: Rig) -> Outcome:
    """What `suggest` said about a model."""
    said = said_by(found)
    own = _own(said, found, model)
    named = [h.model for h in found.found if set(h.names) & {*said, *own}] or [found.before.model]
    out = Outcome(found.verdict, said, own, _values(named), _held(model), faulty=_faulty(found.uses))
    if found.wrong_input is not None:
        out.wrong, out.shift_mm = (found.wrong_input.run, found.wrong_input.signal), found.wrong_input.shift_mm
    if found.unexplained is not None:
        unknown = unknown_of(found.unexplained.candidate, rig)
        out.place_mm, out.follows, out.channel = unknown.at_mm, unknown.follower.name, unknown.channel or ""
        rivals = [unknown_of(rival.candidate, rig) for rival in found.unexplained.rivals]
        out.as_well = [rival.follower.name for rival in rivals if rival.at_mm == unknown.at_mm]
    if found.composed is not None:
        out.composed = [found.composed.effect.name]
    return out


def of_improvement(done: Improvement, model: Model) -> Outcome:
    """What `improve` made of a model."""
    said = list(dict.fromkeys(name for step in done.kept for name in (*step.added.split(" + "), *step.tie) if name))
    verdict, own = done.last.verdict if done.last else "stopped", _own(said, done.last, model)
    out = Outcome(verdict, said, own, _values([done.model]), _held(model), faulty=_faulty(done.uses))
    held = [figures(step.held_out) for step in done.kept if step.held_out is not None]
    out.before, out.after = (held[0], held[-1]) if held else ((), ())
    if done.composed:
        out.composed = [one.effect.name for one in done.composed]
        first = next((one for one in done.composed if one.unknown.at_mm is not None), done.composed[0])
        out.place_mm, out.follows = first.unknown.at_mm, first.unknown.follower.name
        out.as_well = [rival.follower.name for rival in first.rivals]
        out.misread = [_read(one) for one in done.composed if one.unknown.channel is not None]
    return out


def _read(one: Composed) -> list[str]:
    """The channel, "" for all thermometers, and all that its shift may follow, best first."""
    followers = [one.unknown.follower, *(rival.follower for rival in one.rivals)]
    return [one.unknown.channel or "", *(each.name for each in followers)]


def said_by(found: Suggestion) -> list[str]:
    """The effects that a verdict names, best first."""
    if found.verdict not in NAMING:
        return []
    if found.verdict == "effect":
        return [found.found[0].names[0]]
    return list(found.tie if found.verdict == "tie" else found.pair)


def figures(error: Error) -> tuple[float, float]:
    """K, um"""
    return error.temperature_K, error.elongation_um


def _own(said: Sequence[str], last: Suggestion | None, model: Model) -> list[str]:
    changed = [last.changed.partition(".")[0]] if last and last.changed else []
    return [*(name for name in said if name in model.effects), *changed]


def _values(models: Sequence[Model]) -> dict[str, list[float]]:
    return {path: [float(m[path]) for m in models if path in m.values] for path in PATHS}


def _held(model: Model) -> dict[str, float]:
    fixed = set(PATHS) - set(model.free())
    return {path: float(model[path]) if path in model.values else 0.0 for path in sorted(fixed)}


def _faulty(uses: Sequence[Use]) -> list[tuple[str, str]]:
    found = []
    for use in uses:
        jumped = {channel for jump in use.jumps for channel in jump.sizes}
        found += [(use.name, c.channel) for c in use.channels if c.suspect or c.suspicions or c.channel in jumped]
    return found
