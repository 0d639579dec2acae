"""Long work: on which recordings it is done, by which workers, in how many threads, and who hears how far it is."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

from estimator.record import Recording
from estimator.rig import Rig

Workers = Callable[[Callable[[Any], Any], Sequence[Any]], Iterable[Any]]  # `map`, or that of a pool of threads
Progress = Callable[[str, float], None]  # what is being done; the part of all that is done, or steps without an end


P = ParamSpec("P")
R = TypeVar("R")


def one_thread(engine: Callable[P, R]) -> Callable[P, R]:
    """An engine with one thread of the BLAS for the whole process until it returns, then as many as before.

    Matrices of some fifty states are small: two threads take four to ten times the processor time of one.
    """

    @wraps(engine)
    def alone(*given: P.args, **named: P.kwargs) -> R:
        with _libraries().limit(limits=1, user_api="blas"):
            return engine(*given, **named)

    return alone


@cache
def _libraries() -> Any:
    """Those that compute with matrices: numpy has one, scipy another, which the compiler calls."""
    import scipy.linalg  # noqa: F401 before they are looked for
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def silent(stage: str, done: float) -> None:
    """Progress that nobody hears."""


def kept(workers: Workers) -> Workers:
    """Those of workers that keep what they are given, for a job on each of some recordings: processes, if there are."""
    found: Workers = getattr(workers, "kept", workers)
    return found


@dataclass(frozen=True)
class Runs:
    """Recordings of one rig to work on. The engine needs no lock of Python's, so that threads serve as workers."""

    rig: Rig
    recordings: Sequence[Recording]
    workers: Workers = map
    progress: Progress = silent

    def __repr__(self) -> str:
        return f"Runs: {', '.join(one.name for one in self.recordings)} on {self.rig.name}"

    def each(self, job: Callable[[Recording], Any]) -> list[Any]:
        """What a job makes of every recording."""
        return list(kept(self.workers)(job, self.recordings))
