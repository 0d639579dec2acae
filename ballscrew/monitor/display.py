"""What the person at the terminal sees of the monitor, and how they stop it."""

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from types import FrameType

from rich.console import Group
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from ballscrew.monitor.beside import Beside
from ballscrew.monitor.glance import glances
from ballscrew.monitor.status import Status
from ballscrew.terminal import Terminal
from viz.lanes.standing import Glance, Tone

LINE_S = 60.0  # between status lines where the terminal cannot redraw
REDRAW_S = 0.25
SENTENCES = 200  # that wait for a terminal; then new ones are lost to it, and stand in the views only
STOPS = [signal.SIGINT, signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else [])]


class Display:
    """A panel where the terminal can redraw, else a line a minute and what happens. Nobody may be there to read it.

    A terminal that takes nothing, held by Ctrl-S or behind a network that is gone, holds up nobody (`beside`).
    """

    def __init__(self, terminal: Terminal, live: Live | None) -> None:
        self.terminal, self.live = terminal, live
        self._beside, self._next = Beside(SENTENCES), 0.0

    def say(self, text: str, level: str) -> None:
        """One sentence with the time of day."""
        if level == "WARN" or not self.terminal.quiet:
            console = self.live.console if self.live else self.terminal.err
            self._print(partial(console.print, f"{time.strftime('%H:%M:%S')} {text}", markup=False))

    def show(self, status: Status) -> None:
        """The state, as often as it can be read."""
        if time.monotonic() >= self._next and (status.moment is not None or self.live is not None):
            self._next = time.monotonic() + (REDRAW_S if self.live else LINE_S)
            if self._beside.idle:
                self._state(status, "")

    def end(self, status: Status) -> None:
        """How it was at the end."""
        self._state(status, "ended: ")

    def close(self) -> bool:
        """Whether all was printed that there was to print."""
        if self.live is not None:
            self._print(self.live.stop)
        return self._beside.close()

    def _state(self, status: Status, before: str) -> None:
        if self.live is not None:
            self._print(partial(self.live.update, panel(status), refresh=True))
        else:
            self._print(partial(self.terminal.say, f"{before}{status.line()}"))

    def _print(self, job: Callable[[], object]) -> None:
        def printed() -> None:
            with suppress(OSError):
                job()

        self._beside(printed)


@contextmanager
def display(terminal: Terminal) -> Iterator[Display]:
    """The display of this terminal."""
    live = None
    if not terminal.quiet and terminal.out.is_terminal:
        live = Live(console=terminal.out, auto_refresh=False, transient=False)
        live.start()
    screen = Display(terminal, live)
    try:
        yield screen
    finally:
        screen.close()


@contextmanager
def stop_asked() -> Iterator[Callable[[], int]]:
    """A function that says which signal asked us to stop, 0 while none did; a second one stops at once."""
    asked: list[int] = []

    def ask(number: int, frame: FrameType | None) -> None:
        if asked:
            raise KeyboardInterrupt
        asked.append(number)

    # nohup has SIGHUP ignored, and means it
    heard = [number for number in STOPS if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, ask) for number in heard}
    try:
        yield lambda: asked[0] if asked else 0
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


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
