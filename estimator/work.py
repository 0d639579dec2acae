"""How long work is shared out and told of: a job on every recording, by one thread or several."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

Share = Callable[[Callable[[Any], Any], Sequence[Any]], Iterable[Any]]
