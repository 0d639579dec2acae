"""One process a folder: a lock that ends with the process that holds it, however that process ends."""

import os
from contextlib import suppress
from errno import ENOLCK, ENOSYS, EOPNOTSUPP
from pathlib import Path

from filelock import BaseFileLock, FileLock, Timeout

from estimator.errors import SetupError


def lock_folder(folder: Path) -> BaseFileLock:
    """Make a folder and hold its `.lock` until `release`.

    A second holder is a SetupError that names the process of the first; so is a folder that cannot be used.
    """
    path = folder / ".lock"
    lock = FileLock(path, thread_local=False, fallback_to_soft=False)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock.acquire(blocking=False)
    except Timeout:
        raise SetupError(
            f"{folder}: process {_holder(path)} already records there; end it or name another folder"
        ) from None
    except OSError as error:
        if error.errno not in (ENOLCK, ENOSYS, EOPNOTSUPP):  # a network folder without locks
            raise SetupError(f"{folder}: cannot record there: {error.strerror}; name another folder") from None
    else:
        with suppress(OSError):  # a full disk, or Windows: the lock holds all the same
            path.write_text(str(os.getpid()), encoding="ascii")
    return lock


def _holder(path: Path) -> str:
    with suppress(OSError):  # Windows lets nobody read a file that is locked
        return path.read_text(encoding="ascii", errors="replace").strip() or "of another ballscrew"
    return "of another ballscrew"
