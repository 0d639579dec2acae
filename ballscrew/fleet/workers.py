"""Rig folders shared out among processes, or workers of a Dask scheduler; one that is lost costs what it was at, which
is done again."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from socket import gethostname

from ballscrew.fleet.inspection import Inspection, inspected
from ballscrew.workers.by_value import MOST_LOST
from ballscrew.workers.processes import the_cluster

LOST = "its worker was lost again and again: out of memory?"

Job = Callable[[Path], Inspection]


def each(folders: Sequence[Path], workers: int | str, search: bool = False) -> Iterator[Inspection]:
    """Every folder looked at, as they are done; a rig whose worker is lost again and again is one that failed."""
    return shared(partial(inspected, search=search), folders, workers)


def shared(job: Job, folders: Sequence[Path], workers: int | str) -> Iterator[Inspection]:
    """The same of any job."""
    if isinstance(workers, str):
        named = {folder.absolute(): folder for folder in folders}
        for folder, found in the_cluster().shared(partial(_there, job), list(named), workers):
            yield replace(found, folder=str(named[folder])) if found else Inspection(str(named[folder]), error=LOST)
        return
    todo, lost, alone = list(folders), Counter[Path](), workers <= 1
    if alone:
        yield from map(job, todo)
        return
    while todo:
        few = [folder for folder in todo if lost[folder]][:1] or todo  # one that may have killed its worker is alone
        for folder, found in _once(job, few, workers):
            todo.remove(folder)
            yield found
        for folder in few:
            if folder in todo:
                lost[folder] += 1
                if lost[folder] >= MOST_LOST:
                    todo.remove(folder)
                    yield Inspection(str(folder), error=LOST)


def _there(job: Job, folder: Path) -> Inspection:
    """On another machine, which must see the folder too."""
    if folder.is_dir():
        return job(folder)
    return Inspection(str(folder), error=f"{gethostname()} sees no folder {folder}: share it under the same path")


def _once(job: Job, folders: Sequence[Path], workers: int) -> Iterator[tuple[Path, Inspection]]:
    """What is done before a worker is lost."""
    with ProcessPoolExecutor(min(workers, len(folders)), get_context("spawn")) as pool:
        at_work = {pool.submit(job, folder): folder for folder in folders}
        for done in as_completed(at_work):
            try:
                found = done.result()
            except BrokenProcessPool:
                continue
            yield at_work[done], found
