"""Recordings side by side: the compiled engine works without Python's lock, so that threads are enough."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any


@contextmanager
def threads() -> Iterator[Callable[..., Any]]:
    """A `map` that does as many jobs at a time as there are cores."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        yield pool.map
