"""What has changed, asked of the recording in a process of its own while rig and model part."""

import json
import math
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from estimator.alarms.alarms import Alarm

PARTED = ("bias", "nis", "machine", "heat")  # kinds of alarms that say so
AGAIN_S, SOON_S = 3600.0, 600.0  # wall time from one question to the next; where the last was asked too early
POLITE = ("nice", "-n", "10")  # the estimate comes first
LAST = 6  # parts of the recording in which an effect is sought: hours


class Explainer:
    """Runs `diagnose` over the recording as far as it has come, at most once an hour; sooner where nothing showed yet.
    Where the model fails `suggest` then says which effect may be missing, by the last parts.

    parts    gives the files of the recording
    options  which rig and model, as words of a command line
    """

    def __init__(self, parts: Callable[[], Sequence[Path]], options: Sequence[str]) -> None:
        self._parts, self._options, self._due = parts, list(options), -math.inf
        self._running: subprocess.Popen[bytes] | None = None
        self._command = ""
        self._folder = tempfile.TemporaryDirectory(prefix="ballscrew-explain-")

    def look(self, alarms: Iterable[Alarm]) -> str:
        """Ask, if these alarms ask for it; the answer as a sentence once it is there, else ""."""
        if self._running is not None:
            return "" if self._running.poll() is None else self._answer(self._running)
        parted = any(alarm.kind in PARTED for alarm in alarms)
        if parted and time.monotonic() > self._due and (parts := self._parts()):
            self._due = time.monotonic() + AGAIN_S
            self._ask("diagnose", "--join", *map(str, parts))
        return ""

    def close(self) -> None:
        """End what still runs."""
        if self._running is not None:
            self._running.terminate()
            self._running.wait()
        self._folder.cleanup()

    def _ask(self, command: str, *asked: str) -> None:
        self._command = command
        polite = POLITE if shutil.which(POLITE[0]) else ()
        words = [command, *asked, *self._options, "--quiet", "--json", str(self._told)]
        with self._errors.open("wb") as errors:
            self._running = subprocess.Popen(
                [*polite, sys.executable, "-m", "ballscrew", *words], stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL, stderr=errors,
            )  # fmt: skip

    def _answer(self, ended: subprocess.Popen[bytes]) -> str:
        self._running = None
        if not self._told.is_file():
            self._due = time.monotonic() + SOON_S
            last = self._errors.read_text(encoding="utf-8", errors="replace").strip().splitlines()[-1:]
            return f"could not be explained: {' '.join(last) or f'{self._command} ended with {ended.returncode}'}"
        told = json.loads(self._told.read_text(encoding="utf-8"))
        self._told.unlink()
        if self._command == "suggest":
            return f"suggested: {told['sentence']}"
        if told["adequate"] and not told["events"]:
            self._due = time.monotonic() + SOON_S
            return ""
        if not told["adequate"]:
            self._ask("suggest", *map(str, self._parts()[-LAST:]))
        return " ".join(["explained:", *told["sentences"], *(event["sentence"] for event in told["events"])])

    @property
    def _told(self) -> Path:
        return Path(self._folder.name) / "diagnosis.json"

    @property
    def _errors(self) -> Path:
        return Path(self._folder.name) / "errors.txt"
