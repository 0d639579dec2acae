"""Every tab of a live stream as a PNG, through a viewer without a window; and the web page, where there is a Chromium.

python -m viz.viewer.live_pictures rerun+http://127.0.0.1:PORT/proxy FOLDER [--window 1280x800]
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from estimator.errors import BallscrewError
from viz.viewer import browser
from viz.viewer.pictures import GREETING_S, WINDOW, headless, keep, walk
from viz.viewer.web import WebPage

PAGE = "Web.png"


def render(url: str, folder: Path, window: str = WINDOW) -> list[Path]:
    """Write FOLDER/TAB.png for each tab of what the stream at `url` shows now."""
    folder.mkdir(parents=True, exist_ok=True)
    with headless(["--connect", url], window) as client:
        time.sleep(GREETING_S)
        return list(walk(client, folder, set(), views=False))


def render_page(url: str, folder: Path, window: str = WINDOW) -> list[Path]:
    """Write FOLDER/Web.png, the page that shows the stream at `url`; nothing without a Chromium."""
    executable = browser.browser()
    if executable is None:
        return []
    page = WebPage(url)
    try:
        width, height = map(int, window.split("x"))
        return [keep(browser.picture(executable, f"{page.address}&renderer=webgl", width, height), folder / PAGE)]
    finally:
        page.close()


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line above; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m viz.viewer.live_pictures", description="Every tab of a live stream as a PNG, and the web page."
    )
    parser.add_argument("url", help="where the stream is served")
    parser.add_argument("folder", type=Path, help="where the pictures go")
    parser.add_argument("--window", default=WINDOW, metavar="WxH", help=f"size of the window; default: {WINDOW}")
    asked = parser.parse_args(arguments)
    try:
        tabs = render(asked.url, asked.folder, asked.window)
        page = render_page(asked.url, asked.folder, asked.window)
    except BallscrewError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    for path in [*tabs, *page]:
        print(f"{path}  {path.stat().st_size / 1000:.0f} kB")
    if not page:
        print(f"no Chromium here: no {PAGE}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
