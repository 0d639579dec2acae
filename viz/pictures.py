"""Every tab and view of a saved file as a PNG, through the viewer without a window.

    python -m viz.pictures OUT.rrd FOLDER [--at SECONDS] [--only NAME]... [--views]

A machine without a graphics card needs the software renderer of Mesa.
"""

from __future__ import annotations

import argparse
import io
import re
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from PIL import Image
from rerun.experimental import ViewerClient

from estimator.errors import BallscrewError, SetupError
from viz import paths
from viz.viewer import connect, free_port, start

SIZE = (1600, 1000)
GREETING_S = 7.0  # messages of the viewer's start cover the top right corner for so long
NO_ADAPTER = "pictures: no Vulkan adapter; install one: apt-get install mesa-vulkan-drivers"

Layout = dict[str, Any]


def render(
    rrd: Path,
    folder: Path,
    at_s: float | None = None,
    size: tuple[int, int] = SIZE,
    only: Sequence[str] = (),
    views: bool = False,
) -> list[Path]:
    """Write FOLDER/Tab.png for each tab at the moment `at_s` (the end if None), or for those tabs named in `only`.

    views  also a picture of each view by itself
    """
    if not rrd.is_file():
        raise SetupError(f"{rrd}: no such file")
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    with _viewer(rrd, size) as client:
        if at_s is not None:
            client.set_time(paths.TIMELINE, duration=at_s, play_state="paused")
        time.sleep(GREETING_S)
        layout = dict(client.get_blueprint().blueprint)
        for names, tabs in tabs_of(layout, root_of(layout)):
            if only and not set(names) & set(only):
                continue
            _show(client, layout, tabs)
            written.append(_write(client, folder / f"{_file_name(names)}.png", None))
            for view in _views(layout, tabs[-1][1]) if views else ():
                title = layout[f"/{view}"]["ViewBlueprint"]["display_name"]
                name = f"{_file_name(names)}-{_file_name([title])}.png"
                written.append(_write(client, folder / name, view.removeprefix("view/")))
            _complain(client, names)
    return written


@contextmanager
def _viewer(rrd: Path, size: tuple[int, int]) -> Iterator[ViewerClient]:
    """A viewer without a window, with `rrd` loaded and its own top bar hidden."""
    port = free_port()
    with tempfile.TemporaryFile() as said:
        process = start(["--headless", "--window-size", f"{size[0]}x{size[1]}", str(rrd)], port, said)
        try:
            yield connect(port)
        except TimeoutError as error:
            said.seek(0)
            text = said.read().decode(errors="replace")
            raise SetupError(
                NO_ADAPTER if "adapter" in text else f"pictures: {error}: {text.strip()[-200:]}"
            ) from error
        finally:
            process.terminate()
            process.wait(10)


def root_of(layout: Layout) -> str:
    """Path of the outermost container."""
    return f"container/{layout['/viewport']['ViewportBlueprint']['root_container']}"


def tabs_of(
    layout: Layout, container: str, names: tuple[str, ...] = (), chosen: tuple[tuple[str, str], ...] = ()
) -> Iterator[tuple[tuple[str, ...], tuple[tuple[str, str], ...]]]:
    """Each innermost tab: its names from outside in, and which child each container of tabs must show for it."""
    about = layout[f"/{container}"]["ContainerBlueprint"]
    for child in about["contents"]:
        inner = layout[f"/{child}"].get("ContainerBlueprint", {})
        name = inner.get("display_name") or layout[f"/{child}"]["ViewBlueprint"]["display_name"]
        found = (*names, name), (*chosen, (container, child))
        if inner.get("container_kind") == "Tabs":
            yield from tabs_of(layout, child, *found)
        else:
            yield found


def _views(layout: Layout, path: str) -> Iterator[str]:
    if path.startswith("view/"):
        yield path
        return
    for child in layout[f"/{path}"]["ContainerBlueprint"]["contents"]:
        yield from _views(layout, child)


def _show(client: ViewerClient, layout: Layout, tabs: tuple[tuple[str, str], ...]) -> None:
    for container, child in tabs:
        layout[f"/{container}"]["ContainerBlueprint"]["active_tab"] = child
    client.set_blueprint(layout, store_id=client.get_state().active_recording)
    time.sleep(1.0)


def _write(client: ViewerClient, path: Path, view: str | None, timeout_s: float = 20.0) -> Path:
    """Take pictures until two are the same: then all data has arrived."""
    before, end = b"", time.monotonic() + timeout_s
    while (now := client.take_screenshot(view)) != before and time.monotonic() < end:
        before = now
        time.sleep(0.5)
    Image.open(io.BytesIO(now)).convert("RGB").save(path, optimize=True)
    return path


def _complain(client: ViewerClient, names: Sequence[str]) -> None:
    for view in client.get_state().views:
        if view.visible and view.reports:
            print(f"{' / '.join(names)}: {view.name}: {view.reports}", file=sys.stderr)


def _file_name(names: Sequence[str]) -> str:
    return "-".join(re.sub(r"[^A-Za-z0-9.]+", "_", name).strip("_")[:40] for name in names)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line above; returns the exit code."""
    assert __doc__
    parser = argparse.ArgumentParser(prog="python -m viz.pictures", description=__doc__.splitlines()[0])
    parser.add_argument("rrd", type=Path, help="a file saved by review")
    parser.add_argument("folder", type=Path, help="where the pictures go")
    parser.add_argument("--at", type=float, default=None, metavar="SECONDS", help="moment to show; default: the end")
    parser.add_argument("--only", action="append", default=[], metavar="TAB", help="only tabs with this name")
    parser.add_argument("--views", action="store_true", help="each view by itself, too")
    asked = parser.parse_args(arguments)
    try:
        for path in render(asked.rrd, asked.folder, asked.at, only=asked.only, views=asked.views):
            print(f"{path}  {path.stat().st_size / 1000:.0f} kB")
    except BallscrewError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main())
