"""All candidates at once, none of them fitted: how much of the misfit each explains, and how large it is then.

Each is taken at its null beside the model's own parameters; signed, and inside its bounds. Of an effect that may sit in
many places the best few are judged on recordings left out.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.batch.trials import Trials
from estimator.hypotheses.candidates import Candidate
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.panel import Explanation, Panel
from estimator.hypotheses.slopes import Column
from estimator.model import Model

GROUP = 96  # columns in one pass
SEATS = 2  # of an effect, that are judged


@dataclass(frozen=True)
class Screened:
    """A candidate and what it explains; `first`: values from which a full fit may begin.

    doubles  whether it does to every reading what one of the model's own parameters does
    """

    candidate: Candidate
    judged: Explanation
    first: Mapping[str, float]
    doubles: bool = False


@dataclass(frozen=True)
class Screening:
    """All candidates on one ground, best seats only.

    own  what each of the model's own parameters explains if it alone is of another value than the ground says
    """

    ground: Ground
    own: Mapping[str, Explanation]
    found: tuple[Screened, ...]

    def best(self) -> list[Screened]:
        """The best seat of each effect, best effect first."""
        best: dict[str, Screened] = {}
        for each in sorted(self.found, key=lambda s: s.judged.misfit):
            best.setdefault(each.candidate.name, each)
        return list(best.values())


def screening(
    ground: Ground, wide: Model, candidates: Sequence[Candidate], trials: Trials, seats: int = SEATS
) -> Screening:
    """Screen candidates beside a ground; `wide` is its model with all of them at their nulls.

    Candidates that move no reading of these recordings are left out; so many seats of each effect are judged.
    """
    columns = [Column(wide, path) for path in ground.paths]
    found: list[Screened] = []
    for group in _groups(candidates):
        more = [*columns, *(Column(c.place(wide), path) for c in group for path in c.paths)]
        known = ground.belief(wide, [column.path for column in more])
        found += _screened(group, len(columns), Panel.of(trials, wide, more, known, ground.model), seats)
    return Screening(ground, own_parameters(ground, trials), tuple(found))


def own_parameters(ground: Ground, trials: Trials) -> dict[str, Explanation]:
    """What each own parameter explains that alone is of another value than the ground says: learned, or held."""
    paths = [*ground.paths, *ground.held]
    panel = Panel.of(trials, ground.model, [Column(ground.model, path) for path in paths], own=ground.model)
    found = {}
    for path, shows in zip(paths, panel.shows(), strict=True):
        if shows and (path in ground.learned or path not in ground.paths):
            known = ground.freed(path).belief(ground.model, paths)
            moving = [i for i, other in enumerate(paths) if other in ground.paths or other == path]
            found[path] = panel.believing(known).judge(moving)
    return found


def _groups(candidates: Sequence[Candidate]) -> list[list[Candidate]]:
    """Candidates in groups of limited size, the seats of one effect together."""
    groups: list[list[Candidate]] = []
    for each in candidates:
        if not groups or len(groups[-1]) >= GROUP:
            groups.append([])
        groups[-1].append(each)
    return groups


def _screened(group: Sequence[Candidate], k: int, panel: Panel, most: int) -> list[Screened]:
    """The best seats of a group; the first `k` parameters of the panel are the ground's."""
    sizes = [len(c.paths) for c in group]
    starts = k + np.append(0, np.cumsum(sizes[:-1])).astype(int)
    gain, shows, doubles = panel.gains(range(k)), panel.shows(), panel.double(range(k))
    kept: list[int] = []
    for name in {c.name for c in group}:
        seats = [i for i, c in enumerate(group) if c.name == name and shows[starts[i] : starts[i] + sizes[i]].any()]
        kept += sorted(seats, key=lambda i: -float(gain[starts[i] : starts[i] + sizes[i]].max()))[:most]
    judged = [(i, panel.judge([*range(k), *range(starts[i], starts[i] + sizes[i])])) for i in sorted(kept)]
    whole = [bool(doubles[starts[i] : starts[i] + sizes[i]].all()) for i, _ in judged]
    return [
        Screened(group[i], explained, panel.values(explained), double)
        for (i, explained), double in zip(judged, whole, strict=True)
    ]
