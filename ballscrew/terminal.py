"""What a person sees: tables, progress, one-line notes; and JSON for programs."""

import json
import math
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

Rows = Sequence[Sequence[str]]  # of a table, its head first

STDOUT = "-"
INTERRUPTED = 130
FILE_WIDTH = 120  # of tables that go to a file or a pipe


class Terminal:
    """Where a command writes: tables to stdout, or to stderr when stdout carries JSON; nothing when quiet."""

    def __init__(self, json_path: str | None = None, quiet: bool = False) -> None:
        self.json_path = json_path
        self.quiet = quiet
        self.out = Console(stderr=json_path == STDOUT, quiet=quiet, highlight=False, soft_wrap=True)
        if not self.out.is_terminal:
            self.out.width = FILE_WIDTH
        self.err = Console(stderr=True, highlight=False, soft_wrap=True)

    def say(self, text: str = "") -> None:
        """One line (or a paragraph) for the reader."""
        self.out.print(text, markup=False)

    def say_if_compiling(self, *functions: str) -> None:
        """Why the first run after an installation takes longer; the functions of the engine that it needs."""
        from estimator.batch import batch  # the compiler takes a while to import

        if batch.is_cold(*(getattr(batch, name) for name in functions)) and not self.quiet:
            self.err.print("compiling the filter for this machine, once: some 15 s", markup=False)

    def say_views(self, path: Path) -> None:
        """Where the views are, and how to look at them."""
        rerun = os.path.relpath(Path(sys.executable).with_name("rerun"))
        self.say(f"views: {path}   (open with: {rerun} --bind 127.0.0.1 {path})")

    def warn(self, text: str) -> None:
        """One line on stderr, also when quiet."""
        self.err.print(f"note: {text}", markup=False)

    def error(self, text: str) -> None:
        """One line on stderr: an input that could not be used."""
        self.err.print(f"error: {text}", markup=False)

    def table(self, rows: Rows, prose: int = -1, title: str = "") -> None:
        """A table, its head first: a name, then numbers with their unit in the head; the column `prose` holds text."""
        table = Table(
            title=title, title_justify="left", title_style="bold", box=None, pad_edge=False, header_style="dim"
        )
        head, *rest = rows
        for i, column in enumerate(head):
            table.add_column(column, justify="left" if i in (0, prose) else "right", no_wrap=i != prose)
        for row in rest:
            table.add_row(*row)
        self.out.print(table, soft_wrap=False)

    def show_views(self, path: Path, view: bool, at_s: float | None = None) -> None:
        """Say where the views are, and open them if asked, with the cursor at `at_s` or at their own moment."""
        from viz.viewer.viewer import open_viewer  # rerun takes half a second to import

        self.say_views(path)
        if view and not open_viewer(path, at_s):
            self.say("no screen here: the viewer was not started")

    @contextmanager
    def progress(self, label: str, total: float | None) -> Iterator[Any]:
        """A progress bar on stderr; yields update(completed, label=None)."""
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[detail]}"),
            TimeElapsedColumn(),
        )
        with Progress(
            *columns, console=self.err, transient=True, disable=self.quiet or not self.err.is_terminal
        ) as bar:
            task = bar.add_task(label, total=total, detail="")
            yield lambda done, detail="": bar.update(task, completed=done, detail=detail)

    def json(self, data: Mapping[str, Any] | Sequence[Any]) -> None:
        """Write the result where --json asked for it."""
        if self.json_path is None:
            return
        text = json.dumps(plain(data), indent=2, ensure_ascii=False)
        if self.json_path == STDOUT:
            print(text)
        else:
            Path(self.json_path).write_text(text + "\n", encoding="utf-8")


def plain(value: Any, digits: int = 6) -> Any:
    """Numbers as JSON has them: numpy types unwrapped, to so many digits, NaN and infinity as null."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, Mapping):
        return {str(key): plain(item, digits) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item, digits) for item in value]
    if isinstance(value, int):
        return value if isinstance(value, bool) else int(value)
    if isinstance(value, float):
        return float(f"{value:.{digits}g}") if math.isfinite(value) else None
    return value


def duration(seconds: float) -> str:
    """2 h 06 min, 42 min 10 s, 12 s."""
    minutes, s = divmod(round(seconds), 60)
    h, m = divmod(minutes, 60)
    if h:
        return f"{h} h {m:02d} min"
    return f"{m} min {s:02d} s" if m else f"{s} s"
