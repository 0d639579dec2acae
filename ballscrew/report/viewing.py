"""Opening saved views in the rerun viewer, where there is a screen."""

from __future__ import annotations

from pathlib import Path

import click

from ballscrew.terminal import Terminal

view_option = click.option("--view", is_flag=True, help="Open the views in the rerun viewer, where there is a screen.")


def show(terminal: Terminal, path: Path, view: bool, at_s: float | None = None) -> None:
    """Say where the views are, and open them if asked, with the cursor at `at_s` or at their own moment."""
    from viz.viewer.viewer import open_viewer  # rerun takes half a second to import

    terminal.say_views(path)
    if view and not open_viewer(path, at_s):
        terminal.say("no screen here: the viewer was not started")
