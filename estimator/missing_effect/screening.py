"""All candidates at once, none of them fitted: how much of the misfit each explains, and how large it is then.

Each is taken at its null, alone and beside the model's own parameters; signed, and inside its bounds. Of an effect that
may sit in many places the best few are judged on recordings left out.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimator.batch.trials import Trials
from estimator.missing_effect.candidates import Candidate
from estimator.missing_effect.moments import Column
from estimator.missing_effect.panel import Explanation, Panel
from estimator.model import Model

GROUP = 96  # columns in one pass
SEATS = 2  # of an effect, that are judged


@dataclass(frozen=True)
class Screened:
    """A candidate, and what it explains while the model's own parameters stay [0], or are fitted again [1].

    first  values from which a full fit may begin, of the candidate's parameters and of all
    """

    candidate: Candidate
    judged: tuple[Explanation, Explanation]
    first: tuple[Mapping[str, float], Mapping[str, float]]


@dataclass(frozen=True)
class Screening:
    """All candidates, best seats only; `own`: what each of the model's own parameters explains alone, by its path."""

    own: Mapping[str, Explanation]
    found: tuple[Screened, ...]

    def best(self, refit: bool) -> list[Screened]:
        """The best seat of each effect, best effect first."""
        best: dict[str, Screened] = {}
        for each in sorted(self.found, key=lambda s: s.judged[refit].misfit):
            best.setdefault(each.candidate.name, each)
        return list(best.values())


def screening(
    model: Model, wide: Model, candidates: Sequence[Candidate], trials: Trials, loose: Collection[str] = ()
) -> Screening:
    """Screen candidates of a model; `wide` is the model with all of them at their nulls.

    loose  the model's own parameters that move although the others stay

    Candidates that move no reading of these recordings are left out.
    """
    own = [Column(wide, path) for path in model.free()]
    found: list[Screened] = []
    panel = Panel.of(trials, wide, own)
    anyhow = [i for i, column in enumerate(own) if column.path in loose]
    for group in _groups(candidates):
        columns = [Column(c.place(wide), path) for c in group for path in c.paths]
        found += _screened(group, anyhow, len(own), Panel.of(trials, wide, [*own, *columns]))
    singly = {column.path: panel.judge(sorted({*anyhow, i})) for i, column in enumerate(own)}
    return Screening(singly, tuple(found))


def _groups(candidates: Sequence[Candidate]) -> list[list[Candidate]]:
    """Candidates in groups of limited size, the seats of one effect together."""
    groups: list[list[Candidate]] = []
    for each in candidates:
        if not groups or len(groups[-1]) >= GROUP:
            groups.append([])
        groups[-1].append(each)
    return groups


def _screened(group: Sequence[Candidate], anyhow: Sequence[int], k: int, panel: Panel) -> list[Screened]:
    """The best seats of a group; the first `k` parameters of the panel are the model's own, some move anyhow."""
    sizes = [len(c.paths) for c in group]
    starts = k + np.append(0, np.cumsum(sizes[:-1])).astype(int)
    gains, shows = [panel.gains(anyhow), panel.gains(range(k))], panel.shows()
    kept: set[int] = set()
    for name in {c.name for c in group}:
        seats = [i for i, c in enumerate(group) if c.name == name and shows[starts[i] : starts[i] + sizes[i]].any()]
        for gain in gains:
            kept |= set(sorted(seats, key=lambda i: -float(gain[starts[i] : starts[i] + sizes[i]].max()))[:SEATS])
    judged = []
    for i in sorted(kept):
        at = range(starts[i], starts[i] + sizes[i])
        both = panel.judge([*anyhow, *at]), panel.judge([*range(k), *at])
        judged.append(Screened(group[i], both, (panel.values(both[0]), panel.values(both[1]))))
    return judged
