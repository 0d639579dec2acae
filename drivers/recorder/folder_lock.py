"""One process a folder: a lock that ends with the process that holds it, however that process ends."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from estimator.errors import SetupError

try:
    from fcntl import LOCK_EX, LOCK_NB, flock
except ImportError:  # no such lock on this system: recordings still never share a file
    flock = None  # type: ignore[assignment]


class FolderLock:
    """Holds `folder/.lock`; a second holder is a SetupError that names the process of the first."""

    def __init__(self, folder: Path) -> None:
        self._fd = os.open(folder / ".lock", os.O_RDWR | os.O_CREAT, 0o644)
        try:
            self._take(folder)
        except BaseException:
            os.close(self._fd)
            raise

    def release(self) -> None:
        """Let go; the file stays."""
        os.close(self._fd)

    def _take(self, folder: Path) -> None:
        if flock is None:
            return
        try:
            flock(self._fd, LOCK_EX | LOCK_NB)
        except BlockingIOError:
            holder = os.read(self._fd, 20).decode("ascii", "replace").strip()
            raise SetupError(
                f"{folder}: process {holder or 'of another ballscrew'} already records there; "
                "end it or name another folder"
            ) from None
        except OSError:
            return  # a network folder without locks
        with suppress(OSError):  # a full disk: the lock holds all the same
            os.ftruncate(self._fd, 0)
            os.write(self._fd, str(os.getpid()).encode())
