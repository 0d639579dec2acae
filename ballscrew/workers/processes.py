"""Processes that keep what they are given: a recording, or what was made of it, travels once, then only jobs do.

The search asks the same recordings hundreds of questions, most of which are Python and wait for its lock: threads share
two cores no better than one and a quarter. The numbers are the same to the bit, whoever works.
"""

import os
import signal
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from threading import Lock
from typing import Any

from ballscrew.workers.by_value import KEPT, MOST_LOST, answered, done, dumps, loads
from estimator.errors import InputError, SetupError
from estimator.work import Workers

WORTH_S = 7200.0  # recorded, by default: to start processes takes a second or two


def enough(recorded_s: Sequence[float]) -> int:
    """How many processes serve recordings of such lengths: one a core, where starting them pays."""
    return min(os.cpu_count() or 1, len(recorded_s)) if sum(recorded_s) >= WORTH_S else 1


@contextmanager
def working(processes: int | str = 1) -> Iterator[Workers]:
    """A `map` with a thread for each core, and of several processes, those that keep what they are given.

    Instead of processes, the workers of a Dask scheduler: its address.
    """
    with ThreadPoolExecutor(os.cpu_count()) as pool, ExitStack() as stack:
        if isinstance(processes, str):
            cluster = the_cluster()
            yield cluster.Cluster(pool.map, stack.enter_context(cluster.connected(processes)))
            return
        homes = [stack.enter_context(Home()) for _ in range(processes)] if processes > 1 else []
        yield Keepers(pool.map, homes) if homes else pool.map


def the_cluster() -> Any:
    """The module of Dask's workers, which takes half a second to import; a SetupError where they are not installed."""
    try:
        from ballscrew.workers import cluster
    except ModuleNotFoundError as error:
        raise SetupError(f"--workers: there is no {error.name} here; `pip install 'ballscrew[cluster]'`") from None
    return cluster


class Keepers:
    """Workers of both kinds: called, threads; `kept`: processes, for what is done on each of some recordings."""

    def __init__(self, threads: Workers, homes: "Sequence[Home]") -> None:
        self._threads, self._homes = threads, homes

    def __call__(self, job: Callable[[Any], Any], items: Sequence[Any]) -> Any:
        return self._threads(job, items)

    def kept(self, job: Callable[[Any], Any], items: Sequence[Any]) -> list[Any]:
        """What a job makes of each item, each always by the same process."""
        text, packed = dumps(job), {n: dumps(item) for n, item in enumerate(items) if self._home_of(item) is None}
        homes = self._shared(items, packed)
        asked = [home.ask(text, item, packed.get(n)) for n, (home, item) in enumerate(zip(homes, items, strict=True))]
        return [answer.result() for answer in asked]

    def _home_of(self, item: Any) -> "Home | None":
        return next((home for home in self._homes if home.size(item)), None)

    def _shared(self, items: Sequence[Any], packed: Mapping[int, bytes]) -> "list[Home]":
        """A home for each item: where it is, or else, the largest first, where there is least to do.

        Bytes stand for work: a recording that is twice as long as the others takes as long as two of them.
        """
        at, load = [self._home_of(item) for item in items], dict.fromkeys(self._homes, 0)
        for home, item in zip(at, items, strict=True):
            if home is not None:
                load[home] += home.size(item)
        for n in sorted(packed, key=lambda n: -len(packed[n])):
            at[n] = least = min(load, key=lambda home: load[home])
            load[least] += len(packed[n])
        return [home for home in at if home is not None]


class Home:
    """One process and what it keeps. It is started with the first job, and anew where it is lost before the end."""

    def __init__(self) -> None:
        self._over, self._starting = False, Lock()
        self._line = ThreadPoolExecutor(1)
        self._kept: OrderedDict[int, tuple[Any, int]] = OrderedDict()
        self._process: Any = None
        self._pipe: Connection | None = None

    def __enter__(self) -> "Home":
        return self

    def __exit__(self, *_: object) -> None:
        with self._starting:
            self._over = True
            if self._process is not None:
                self._process.kill()  # who waits for its answer is told so by that
        self._line.shutdown(cancel_futures=True)
        self._end()

    def size(self, item: Any) -> int:
        """In bytes, of an item that the process keeps; 0: it does not."""
        return self._kept.get(id(item), (item, 0))[1]

    def ask(self, job: bytes, item: Any, packed: bytes | None = None) -> Any:
        """The future of what a job makes of an item, which may be at hand in bytes; an error there is raised here."""
        return self._line.submit(self._asked, job, item, packed)

    def _asked(self, job: bytes, item: Any, packed: bytes | None) -> Any:
        for _ in range(MOST_LOST):
            try:
                text = self._answer(job, item, packed)
            except (EOFError, ConnectionError):
                self._end()
                continue
            return answered(text)
        raise InputError(f"a process was lost {MOST_LOST} times at one job: out of memory? Go on with --workers 1")

    def _answer(self, job: bytes, item: Any, packed: bytes | None) -> bytes:
        if self._pipe is None:
            self._begin()
        assert self._pipe is not None
        gone = [] if id(item) in self._kept or len(self._kept) < KEPT else [self._kept.popitem(last=False)[0]]
        size = self.size(item)
        packed = None if size else packed or dumps(item)
        self._pipe.send((job, id(item), packed, gone))
        self._kept[id(item)] = item, size or len(packed or b"")  # as long as it lives no other has its id
        self._kept.move_to_end(id(item))
        return self._pipe.recv_bytes()

    def _begin(self) -> None:
        with self._starting:
            if self._over:
                raise EOFError
            context = get_context("spawn")
            self._pipe, other = context.Pipe()
            self._process = context.Process(target=serve, args=(other,), daemon=True)
            self._process.start()
            other.close()

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
        if self._pipe is not None:
            self._pipe.close()
        self._process = self._pipe = None
        self._kept.clear()


def serve(pipe: Connection) -> None:
    """Do jobs until nobody asks any more. Ctrl-C is for who asks."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    kept: dict[int, Any] = {}
    while True:
        try:
            job, key, item, gone = pipe.recv()
        except EOFError:
            return
        for each in gone:
            del kept[each]
        if item is not None:
            kept[key] = loads(item)
        pipe.send_bytes(done(job, kept[key]))
