"""What no effect of the catalogue explains: the stand-in that leaves least, and those that leave as little.

All stand-ins are screened, and the best few move to their places. At the best of these every follower that can reach
it is asked again, those too that the screen has not. The rest are rivals where recordings cannot tell them from it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from estimator.batch.trials import Trials
from estimator.hypotheses.candidates import APART_MM, Candidate, candidates
from estimator.hypotheses.criterion import alike, behind
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.hypothesis import Hypothesis, refined
from estimator.hypotheses.panel import Explanation, Panel
from estimator.hypotheses.screening import Screened, screening
from estimator.hypotheses.slopes import Column
from estimator.inputs.follower import all_followers
from estimator.inputs.reach import reaches
from estimator.model import Model, Value
from estimator.rig import Rig
from estimator.unknown.stand_ins import STAND_INS, UnknownHeat, unknown_of

SEATS = 30  # of each stand-in, that are judged: whatever may be a rival
PLACES = 3  # that are fitted in full: the screen, straight from no effect at all, may promise most of a wrong one
NEAR_MM = 2 * APART_MM  # what is nearer is the same place


@dataclass(frozen=True)
class Rival:
    """A stand-in that explains as much, and by how many standard errors it leaves more than the best.

    first  values from which a full fit may begin
    """

    candidate: Candidate
    judged: Explanation
    first: Mapping[str, float]
    difference_se: float


@dataclass(frozen=True)
class Unexplained:
    """The best stand-in, fitted in full.

    candidate  where it has moved to;  rivals: best first;  tried: how many there were
    there      the same place with each follower else, best first, rival or not
    """

    candidate: Candidate
    hypothesis: Hypothesis
    rivals: tuple[Rival, ...]
    tried: int
    there: tuple[Screened, ...]

    @property
    def judged(self) -> Explanation:
        """How well it explains recordings left out."""
        return self.hypothesis.judged

    def strength(self) -> dict[str, Value]:
        """How strong it is, by unit: its parameters that are no place."""
        own = self.hypothesis.own()
        return {self.hypothesis.model.param(path).unit: own[path] for path in self.candidate.paths}


def best_stand_in(ground: Ground, trials: Trials, channels: Sequence[str] = ()) -> Unexplained | None:
    """What is in no catalogue and explains most; None where no stand-in moves a reading.

    channels  of these readings one is wrong, and nothing else is asked for
    """
    rig = trials[0].rig
    wide, listed = candidates(ground.model, rig, STAND_INS)
    listed = [each for each in listed if _can_be(each, rig)]
    if channels:
        listed = [each for each in listed if unknown_of(each, rig).channel in channels]
    seats = sorted(screening(ground, wide, listed, trials, SEATS).found, key=_misfit)
    if not seats:
        return None
    few = [(seat.candidate, refined(ground, trials, [seat.candidate], seat.first)) for seat in _places(seats)[:PLACES]]
    best_seat, h = min(few, key=lambda one: one[1].misfit)
    here = _moved(best_seat, h)
    asked = sorted(_asked(ground, wide, here, trials), key=_misfit)
    best = asked[0]
    if best.candidate.at != here.at:
        h = refined(ground, trials, [best.candidate], best.first)
    found = _moved(best.candidate, h)
    followers = [replace(each, candidate=_there(each.candidate, found)) for each in asked[1:]]
    elsewhere = _places([each for each in seats if not _one_place(each.candidate, found)])
    rest = sorted([*followers, *elsewhere], key=_misfit)
    rivals = [
        Rival(each.candidate, each.judged, each.first, behind(each.judged, best.judged))
        for each in rest
        if alike(each.judged, best.judged, len(listed))
    ]
    return Unexplained(found, h, tuple(rivals), len(listed), tuple(followers))


def _misfit(one: Screened) -> float:
    return one.judged.misfit


def _can_be(candidate: Candidate, rig: Rig) -> bool:
    """Whether what a stand-in follows can reach its place; a reading may follow anything."""
    if candidate.kind == "reading":
        return True
    unknown = unknown_of(candidate, rig)
    return reaches(unknown.follower, rig, [] if unknown.at_mm is None else [unknown.at_mm])


def _moved(candidate: Candidate, h: Hypothesis) -> Candidate:
    """A stand-in where a fit has put it."""
    return replace(candidate, at={path: float(h.model[path]) for path in candidate.at})


def _there(candidate: Candidate, other: Candidate) -> Candidate:
    """A stand-in at the place of another, which follows what it did."""
    follows = f"{candidate.name}.follows"
    return replace(candidate, at={**other.at, follows: candidate.at[follows]})


def _asked(ground: Ground, wide: Model, here: Candidate, trials: Trials) -> Iterator[Screened]:
    """A stand-in at its place with every follower that can reach it."""
    rig, follows = trials[0].rig, f"{here.name}.follows"
    seats = [replace(here, at={**here.at, follows: float(i)}) for i in range(len(all_followers(rig)))]
    seats = [each for each in seats if _can_be(each, rig)]
    columns = [Column(wide, path) for path in ground.paths]
    more = [Column(each.place(wide), path) for each in seats for path in each.paths]
    known = ground.belief(wide, [column.path for column in (*columns, *more)])
    panel = Panel.of(trials, wide, [*columns, *more], known, ground.model)
    for i, (each, shows) in enumerate(zip(seats, panel.shows()[len(columns) :], strict=True), start=len(columns)):
        if shows:
            explained = panel.judge([*range(len(columns)), i])
            yield Screened(each, explained, panel.values(explained))


def _places(seats: Sequence[Screened]) -> list[Screened]:
    """The best of each place, body or reading, of seats that stand best first."""
    kept: list[Screened] = []
    for each in seats:
        if not any(_one_place(each.candidate, other.candidate) for other in kept):
            kept.append(each)
    return kept


def _one_place(one: Candidate, other: Candidate) -> bool:
    """Whether two stand-ins are the same but for what they follow."""
    if one.name != other.name:
        return False
    if one.effect is UnknownHeat:
        return abs(one.at["unknown_heat.at"] - other.at["unknown_heat.at"]) < NEAR_MM
    where = [path for path in one.at if not path.endswith(".follows")]
    return all(one.at[path] == other.at[path] for path in where)
