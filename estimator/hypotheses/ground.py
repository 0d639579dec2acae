"""What is taken as known of a model's own parameters, while something is looked for beside them.

Two grounds. Either an earlier fit to other recordings of this machine holds, give or take its sd and correlations: then
one thing has changed. Or only tables hold: the model is of another machine, or was fitted to these very recordings, so
that what is missing has bent it. An effect is judged against the model without it on the same ground.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from estimator.model import Model
from estimator.sensitivity.prior import Belief, belief
from estimator.work import Runs


@dataclass(frozen=True)
class Ground:
    """A model from which a search begins, and the paths of its own parameters that move.

    learned  those of which what the model says is their prior; of the others it is their table
    refit    whether only tables hold
    """

    model: Model
    paths: tuple[str, ...]
    learned: frozenset[str] = frozenset()
    refit: bool = False

    def belief(self, wider: Model, paths: Sequence[str]) -> Belief:
        """What is known of these parameters of a model with more effects, moved or not."""
        held = {path: self.model.values[path] for path in self.learned}
        return belief(wider.with_values(held), paths, self.learned)

    def freed(self, *paths: str) -> "Ground":
        """The same, but of some own parameters only their tables are known."""
        return replace(self, paths=tuple(dict.fromkeys([*self.paths, *paths])), learned=self.learned - {*paths})

    @property
    def held(self) -> list[str]:
        """Own parameters that do not move, but say something of the physics: there is a table of them."""
        model = self.model
        return [path for path in model.values if path not in self.paths and model.param(path).sd]


def as_given(model: Model, runs: Runs, loose: Collection[str] = ()) -> Ground:
    """What the model says holds.

    loose  effects whose parameters were found from these recordings while more was missing: they move
    """
    moved = [path for path in model.free() if path.partition(".")[0] in loose]
    known = [] if seen(model, runs) else [path for path in model.free() if model.values[path].sd and path not in moved]
    return Ground(model, (*moved, *known), frozenset(known))


def of_tables(model: Model) -> Ground:
    """Only tables hold: all free parameters move."""
    return Ground(model, tuple(model.free()), refit=True)


def seen(model: Model, runs: Runs) -> bool:
    """Whether a model was fitted to any of these recordings."""
    known = set(model.about.get("fitted_on", {}).values())
    return any(recording.fingerprint in known for recording in runs.recordings)
