"""Workers of a Dask scheduler, on this machine or on others: a recording travels to one once, then only jobs do.

Dask shares out what there is to do, and does again what a lost worker was at; what that worker kept travels once more.
"""

import asyncio
import logging
import warnings
from collections import OrderedDict
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from functools import cached_property, partial
from queue import Empty, SimpleQueue
from threading import Lock
from time import monotonic, sleep
from typing import Any

from distributed import Client, Future, KilledWorker, rpc
from distributed.versions import VersionMismatchWarning

from ballscrew.workers.by_value import KEPT, MOST_LOST, answered, done, dumps, loads
from estimator.errors import InputError, SetupError
from estimator.work import Workers, one_thread

ANSWER_S = 10.0  # of a scheduler
STILL_THERE_S = 30.0  # after so long without a result it is asked whether anybody works; a lost worker starts anew
SAME = ("python", "ballscrew", "cloudpickle", "dask", "distributed", "filterpy", "numba", "numpy", "scipy")

_one_job = Lock()


@contextmanager
def connected(address: str) -> Iterator[Client]:
    """A client of the scheduler at tcp://HOST:PORT; a SetupError where it, or a worker of its, will not do."""
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # of what is lost one line is said, here
    try:
        asyncio.run(asyncio.wait_for(_answer(address), ANSWER_S))
    except Exception as error:  # what else may listen there says anything, or nothing, for which Dask waits for ever
        why = f"no Dask scheduler answers there within {ANSWER_S:g} s; start one, `dask scheduler`"
        raise SetupError(f"--workers {address}: {why}") from error
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VersionMismatchWarning)  # `_check` says it
        client = Client(address, timeout=ANSWER_S, set_as_default=False)
    with client:
        _check(client, address)
        yield client


async def _answer(address: str) -> None:
    async with rpc(address, timeout=ANSWER_S) as scheduler:
        await scheduler.ncores()


def _check(client: Client, address: str) -> None:
    """There must be workers; and the same numbers come of the same versions."""
    until = monotonic() + ANSWER_S
    versions_of: Callable[..., Any] = client.get_versions  # by Dask's types perhaps to be awaited
    while not (versions := versions_of(packages=SAME))["workers"]:
        if monotonic() > until:
            why = f"the scheduler has no worker; start one, `dask worker {address}`"
            raise SetupError(f"--workers {address}: {why}")
        sleep(0.1)
    here = versions["client"]["packages"]
    for worker, told in versions["workers"].items():
        for name in SAME:
            if (there := told["packages"][name]) != here[name]:
                is_there = f"{name} is {there} there" if there else f"there is no {name} there"
                raise SetupError(f"--workers {address}: {worker}: {is_there}, {here[name]} here; install the same")


class Kept:
    """An item that a worker keeps: it travels as bytes, and is made of them once wherever it is."""

    def __init__(self, packed: bytes) -> None:
        self._packed = packed

    @cached_property
    def item(self) -> Any:
        return loads(self._packed)

    def __reduce__(self) -> "tuple[type[Kept], tuple[bytes]]":
        return Kept, (self._packed,)

    def __sizeof__(self) -> int:
        return object.__sizeof__(self) + len(self._packed)  # by which Dask weighs whether to move it


def kept_done(job: bytes, kept: Kept) -> bytes:
    """What a worker makes of what it keeps."""
    return alone(lambda: done(job, kept.item))


def alone(job: Callable[..., Any], *given: Any) -> Any:
    """A job at a time, with one thread of the BLAS, however many threads a worker has: the same numbers."""
    with _one_job:
        return one_thread(job)(*given)


class Cluster:
    """Workers of both kinds: called, threads here; `kept`: those of the scheduler."""

    def __init__(self, threads: Workers, client: Client) -> None:
        self._threads, self._client = threads, client
        self._kept: OrderedDict[int, tuple[Any, Future[Kept]]] = OrderedDict()

    def __call__(self, job: Callable[[Any], Any], items: Sequence[Any]) -> Any:
        return self._threads(job, items)

    def kept(self, job: Callable[[Any], Any], items: Sequence[Any]) -> list[Any]:
        """What a job makes of each item, by a worker that keeps the item."""
        text, found = dumps(job), dict[int, bytes]()
        for _ in range(MOST_LOST):
            with suppress(OSError):  # of a worker that is lost while an item travels to it
                found |= self._tried(text, {n: item for n, item in enumerate(items) if n not in found})
            if len(found) == len(items):
                return [answered(found[n]) for n in range(len(items))]
            _still_there(self._client)
        raise InputError(f"a worker was lost {MOST_LOST} times at one job: out of memory? Go on with --workers 1")

    def _tried(self, job: bytes, items: Mapping[int, Any]) -> dict[int, bytes]:
        """Answers by number, but for items that lived on a worker that was lost: these will travel once more."""
        if self._client.scheduler is None:
            return {}  # as `_still_there` will say
        asked = {n: self._client.submit(kept_done, job, self._there(item), pure=False) for n, item in items.items()}
        for _ in ended(self._client, asked.values()):
            pass
        found = {}
        for n, future in asked.items():
            try:
                found[n] = future.result()
            except (CancelledError, KilledWorker):
                self._kept.pop(id(items[n]), None)
        return found

    def _there(self, item: Any) -> Future[Kept]:
        """The item where it is, or else where there is room for it."""
        if id(item) not in self._kept:
            there = self._client.scatter(Kept(dumps(item)), hash=False, timeout=STILL_THERE_S)
            self._kept[id(item)] = item, there  # as long as it lives no other has its id
            if len(self._kept) > KEPT * len(self._client.nthreads()):
                self._kept.popitem(last=False)
        self._kept.move_to_end(id(item))
        return self._kept[id(item)][1]


def shared(job: Callable[[Any], Any], items: Sequence[Any], address: str) -> Iterator[tuple[Any, Any]]:
    """Items and what a job makes of each, as they are done; None of one whose workers were lost again and again."""
    with connected(address) as client:
        futures = client.map(partial(alone, job), items, pure=False)
        item_of = dict(zip([future.key for future in futures], items, strict=True))
        for future in ended(client, futures):
            try:
                yield item_of[future.key], future.result()
            except KilledWorker:
                yield item_of[future.key], None
            except CancelledError:
                _still_there(client)
                raise


def ended(client: Client, futures: Collection[Future[Any]]) -> Iterator[Future[Any]]:
    """Futures as they end, well or not; an InputError where nobody works any more."""
    line: SimpleQueue[Future[Any]] = SimpleQueue()
    for future in futures:
        future.add_done_callback(line.put)
    for _ in futures:
        while True:
            with suppress(Empty):
                yield line.get(timeout=STILL_THERE_S)
                break
            _still_there(client)


def _still_there(client: Client) -> None:
    scheduler = client.scheduler  # None where it was lost for so long that Dask has closed the client
    with suppress(OSError):
        if scheduler is not None:
            client.wait_for_workers(1, timeout=STILL_THERE_S)
            return
    left = f"{scheduler.address}: the scheduler" if scheduler is not None else "the scheduler"
    raise InputError(f"{left} is lost, or its last worker; start them again, or go on with --workers 1")
