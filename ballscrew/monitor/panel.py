"""How things stand, for a terminal that can redraw: what is read at a glance in boxes of its own, then all the rest."""

from __future__ import annotations

from rich.console import Group
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from ballscrew.monitor.glance import glances
from ballscrew.monitor.status import Status
from viz.lanes.standing import Glance, Tone

STYLES: dict[Tone, str] = {"value": "bold", "valid": "bold green", "invalid": "bold white on red", "stale": "dim"}


def panel(status: Status) -> Panel:
    """The boxes above the rows."""
    large, grid = Table.grid(padding=(0, 1), expand=True), Table.grid(padding=(0, 2))
    boxes = [_box(glance) for glance in glances(status)]
    for _ in boxes:
        large.add_column(ratio=1)
    large.add_row(*boxes)
    for name, text in status.rows():
        grid.add_row(Text(name, style="dim"), Text(text))
    border = "red" if status.alarms else "green"
    return Panel(Group(large, grid), title=Text(status.rig.name), title_align="left", border_style=border)


def _box(glance: Glance) -> Panel:
    """One value, which nothing else comes near in weight."""
    value = f" {glance.value} ", STYLES[glance.tone]
    words = Text.assemble(value, "\n\n", (glance.below, "dim"), justify="center")
    return Panel(words, title=Text(glance.caption, style="dim"), border_style="dim")
