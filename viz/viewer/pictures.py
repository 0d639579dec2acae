"""Every tab of a saved file as a PNG, through the viewer without a window.

    python -m viz.viewer.pictures OUT.rrd FOLDER [--at SECONDS] [--only TAB]... [--window 1600x1000]

A machine without a graphics card needs the software renderer of Mesa.
"""

import argparse
import io
import re
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from PIL import Image
from rerun.experimental import ViewerClient

from estimator.errors import BallscrewError, SetupError
from viz.drawing import paths
from viz.drawing.file import opens_at
from viz.viewer.address import free_port
from viz.viewer.pages import pages_of
from viz.viewer.viewer import connect, start

WINDOW = "1600x1000"
TOP_BAR = 36  # pixels of the window's own bar, blank without a window
GREETING_S = 7.0  # messages of the viewer's start cover the top right corner for so long
PATIENCE_S, RUNNING_S = 20.0, 3.0  # until all has arrived; of a stream that runs, whose pictures all differ
NO_ADAPTER = "pictures: no Vulkan adapter that the viewer can use; install one: apt-get install mesa-vulkan-drivers"


def render_stream(url: str, folder: Path, window: str = WINDOW, only: Sequence[str] = ()) -> list[Path]:
    """Write FOLDER/TAB.png for each tab, or some, of what the live stream at `url` shows now."""
    folder.mkdir(parents=True, exist_ok=True)
    with headless(["--connect", url], window) as client:
        time.sleep(GREETING_S)
        return list(walk(client, folder, {*only}, RUNNING_S))


def render(rrd: Path, folder: Path, at_s: float | None, only: Sequence[str], window: str) -> list[Path]:
    """Write FOLDER/TAB.png for each tab.

    at_s    the moment to show, s; the one that the file remembers if None
    only    names of tabs to take; all if empty
    window  its size in pixels
    """
    if not rrd.is_file():
        raise SetupError(f"pictures: {rrd}: no such file")
    moment = opens_at(rrd) if at_s is None else at_s
    if moment is None:
        raise SetupError(f"pictures: {rrd}: not written by ballscrew; give --at")
    folder.mkdir(parents=True, exist_ok=True)
    with headless([str(rrd)], window) as client:
        client.set_time(paths.TIMELINE, duration=moment, play_state="paused")
        time.sleep(GREETING_S)
        return list(walk(client, folder, {*only}, PATIENCE_S))


def walk(client: ViewerClient, folder: Path, only: set[str], patience_s: float) -> Iterator[Path]:
    """Show one page after the other and write its picture."""
    layout = {**client.get_blueprint().blueprint, "/top_panel": {"PanelBlueprint": {"state": "Hidden"}}}
    for page in pages_of(layout):
        if only and not only & {*page.names}:
            continue
        page.show(layout)
        client.set_blueprint(layout, store_id=client.get_state().active_recording)
        time.sleep(1.0)
        name = "-".join(_word(part) for part in page.names)
        yield _write(client, folder / f"{name}.png", patience_s)
        _complain(client, name)


@contextmanager
def headless(arguments: Sequence[str], window: str) -> Iterator[ViewerClient]:
    """A viewer without a window, with what the arguments name loaded."""
    port = free_port()
    with tempfile.TemporaryFile() as said:
        process = start(["--headless", "--window-size", window, *arguments], port, said)
        try:
            yield connect(process, port)
        except TimeoutError as error:
            said.seek(0)
            raise SetupError(_why(said.read().decode(errors="replace"), error)) from error
        finally:
            process.terminate()
            process.wait(10)


def _why(said: str, error: TimeoutError) -> str:
    """One line on why the viewer is not there."""
    if "graphics adapter" in said or "render context" in said:
        return NO_ADAPTER
    panic = next((line for line in said.splitlines() if "panicked" in line), "")
    return " ".join(f"pictures: {error}; {panic or said[-200:]}".split())


def _write(client: ViewerClient, path: Path, patience_s: float) -> Path:
    """Take pictures until two are the same: then all data has arrived."""
    before, end = b"", time.monotonic() + patience_s
    while (now := client.take_screenshot()) != before and time.monotonic() < end:
        before = now
        time.sleep(0.5)
    return keep(now, path)


def keep(png: bytes, path: Path) -> Path:
    """Write a picture without the window's own bar, as small as it gets."""
    picture = Image.open(io.BytesIO(png)).convert("RGB")
    picture = picture.crop((0, TOP_BAR, *picture.size))
    picture = picture.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE)
    picture.save(path, optimize=True)  # a third of the size
    return path


def _complain(client: ViewerClient, name: str) -> None:
    for view in client.get_state().views:
        if view.visible and view.reports:
            print(f"{name}: {view.name}: {view.reports}", file=sys.stderr)


def _word(name: str) -> str:
    """A name in characters that suit a file."""
    return re.sub(r"[^A-Za-z0-9.]+", "_", name).strip("_")[:40]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line above; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m viz.viewer.pictures", description="Every tab of a saved file as a PNG."
    )
    parser.add_argument("rrd", type=Path, help="a file saved by review or tune")
    parser.add_argument("folder", type=Path, help="where the pictures go")
    parser.add_argument("--at", type=float, metavar="SECONDS", help="moment to show; default: the first stop")
    parser.add_argument("--only", action="append", default=[], metavar="TAB", help="only tabs with this name")
    parser.add_argument("--window", default=WINDOW, metavar="WxH", help=f"size of the window; default: {WINDOW}")
    asked = parser.parse_args(arguments)
    try:
        for path in render(asked.rrd, asked.folder, asked.at, asked.only, asked.window):
            print(f"{path}  {path.stat().st_size / 1000:.0f} kB")
    except BallscrewError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main())
