"""The native viewer as a child process that keeps to itself.

It listens on the loopback only. Usage statistics are off, and what it would ask of the network (its own new versions)
goes to a proxy that is not there: the viewer runs without outbound traffic.
"""

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import IO

from rerun.experimental import ViewerClient

from viz.drawing import paths
from viz.drawing.file import opens_at
from viz.viewer.address import LOOPBACK, free_port

START_S = 20.0
MEMORY = "2GiB"  # what a viewer keeps of a stream; the oldest goes first


def open_viewer(path: Path, at_s: float | None = None) -> bool:
    """Show a saved file, with the cursor at `at_s` or its own moment, and do not wait; False without a screen."""
    if not has_screen():
        return False
    port = free_port()
    viewer = start([str(path)], port)
    at_s = opens_at(path) if at_s is None else at_s
    if at_s is not None:
        connect(viewer, port).set_time(paths.TIMELINE, duration=at_s, play_state="paused")
    return True


def follow(url: str) -> subprocess.Popen[bytes] | None:
    """Show a live stream as it comes, and do not wait; None without a screen."""
    return start(["--memory-limit", MEMORY, "--connect", url], free_port()) if has_screen() else None


def has_screen() -> bool:
    """Whether a window can be shown here."""
    return sys.platform in ("win32", "darwin") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def start(arguments: Sequence[str], port: int, said: IO[bytes] | int = subprocess.DEVNULL) -> subprocess.Popen[bytes]:
    """Start the viewer on the loopback, cut off from the network, in a session of its own; `said` gets its messages."""
    command = [str(executable()), "--bind", LOOPBACK, "--port", str(port), "--hide-welcome-screen", *arguments]
    closed = {"CI": "1", "HTTP_PROXY": "http://127.0.0.1:9", "HTTPS_PROXY": "http://127.0.0.1:9"}
    env = {**os.environ, **closed, "NO_PROXY": "127.0.0.1,localhost", "RUST_LOG": "warn"}
    return subprocess.Popen(
        command, env=env, stdin=subprocess.DEVNULL, stdout=said, stderr=said, start_new_session=True
    )


def executable() -> Path:
    """The viewer that came with rerun-sdk: always the version that wrote the file."""
    import rerun_cli  # type: ignore[import-untyped]

    return Path(rerun_cli.__file__).parent / ("rerun.exe" if sys.platform == "win32" else "rerun")


def connect(viewer: subprocess.Popen[bytes], port: int) -> ViewerClient:
    """Reach a viewer just started, once it has loaded its file; TimeoutError if it does not answer or has ended."""
    end = time.monotonic() + START_S
    while time.monotonic() < end and viewer.poll() is None:
        try:
            client = ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
            state = client.get_state()
        except OSError:  # not up yet
            time.sleep(0.1)
            continue
        if state.recordings and not state.loading:
            return client
        time.sleep(0.1)
    raise TimeoutError("the viewer does not answer")
