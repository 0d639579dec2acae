"""A picture of a page in Chromium without a window, through the pipe by which it takes commands."""

from __future__ import annotations

import base64
import itertools
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
QUIET = (
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-default-apps", "--no-proxy-server", "--hide-scrollbars",
)  # fmt: skip
SOFTWARE = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
PIPED = (
    "import os, sys; os.dup2(int(sys.argv[1]), 3); os.dup2(int(sys.argv[2]), 4); os.execvp(sys.argv[3], sys.argv[3:])"
)
FIRST_S, AGAIN_S, PATIENCE_S = 20.0, 3.0, 240.0  # the page draws without a graphics card


def browser() -> str | None:
    """The browser's executable, None without one."""
    return next((found for name in NAMES if (found := shutil.which(name))), None)


def picture(executable: str, address: str, width: int, height: int) -> bytes:
    """The page as a PNG, once two pictures of it in a row are the same."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile, _page(executable, profile) as page:
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        page.ask("Emulation.setDeviceMetricsOverride", **size)
        page.ask("Page.navigate", url=address)
        time.sleep(FIRST_S)
        before, end = b"", time.monotonic() + PATIENCE_S
        while (now := page.shot()) != before and time.monotonic() < end:
            before = now
            time.sleep(AGAIN_S)
        return now


class _Page:
    """A tab of a browser that listens on a pipe: JSON messages, each with a zero byte at its end."""

    def __init__(self, to: IO[bytes], said: IO[bytes]) -> None:
        self._to, self._said, self._numbers, self._session = to, said, itertools.count(1), ""
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]

    def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Give a command and wait for its answer."""
        number = next(self._numbers)
        message = {"id": number, "method": method, "params": params}
        message |= {"sessionId": self._session} if self._session else {}
        self._to.write(json.dumps(message).encode() + b"\0")
        self._to.flush()
        while (answer := self._next()).get("id") != number:
            pass
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']['message']}")
        return dict(answer["result"])

    def shot(self) -> bytes:
        """What the page looks like, as a PNG."""
        return base64.b64decode(self.ask("Page.captureScreenshot", format="png")["data"])

    def _next(self) -> dict[str, Any]:
        text = bytearray()
        while (byte := self._said.read(1)) != b"\0":
            if not byte:
                raise RuntimeError("the browser has ended")
            text += byte
        return dict(json.loads(text))


@contextmanager
def _page(executable: str, profile: str) -> Iterator[_Page]:
    """A browser of its own, with a tab."""
    theirs, to = os.pipe()
    said, back = os.pipe()
    sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
    flags = ["--headless=new", "--remote-debugging-pipe", f"--user-data-dir={profile}", *QUIET, *SOFTWARE, *sandbox]
    command = [sys.executable, "-c", PIPED, str(theirs), str(back), executable, *flags]
    nothing = subprocess.DEVNULL
    process = subprocess.Popen(command, pass_fds=(theirs, back), stdin=nothing, stdout=nothing, stderr=nothing)
    os.close(theirs)
    os.close(back)
    try:
        with os.fdopen(to, "wb") as to_it, os.fdopen(said, "rb") as from_it:
            yield _Page(to_it, from_it)
    finally:
        process.terminate()
        process.wait(10)
