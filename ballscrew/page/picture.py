"""Drawings by matplotlib as SVG within a page: in its colours, with its letters, all text as it is."""

from __future__ import annotations

import hashlib
import io
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from ballscrew.page.section import Picture
from estimator.inputs.phase import phases
from estimator.record import Array, Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import RcKeyType


COLOURS = {  # light, dark
    "paper": ("#ffffff", "#101216"),
    "ink": ("#1f2328", "#d7dade"),
    "faint": ("#667078", "#8b949e"),
    "line": ("#d5d9de", "#30363d"),
    "shade": ("#eef1f4", "#1b2027"),
    "filter": ("#1f6fc4", "#5aaaff"),
    "smoothed": ("#7a4fc9", "#be96ff"),
    "alone": ("#2e8b45", "#78d282"),
    "polyline": ("#c85a10", "#f0823c"),
    "reading": ("#a87f00", "#fadc3c"),
    "bad": ("#c0392b", "#ff7b72"),
}
STAND_INS = {f"#0d{i:02x}f1": name for i, name in enumerate(COLOURS)}
DRAWN = {name: colour for colour, name in STAND_INS.items()}  # what matplotlib draws in
WIDTH = 7.6  # inches
BINS = 500  # of a curve: two points in each are all that a page can show
DOTS = 400  # of single values
INK: Sequence[RcKeyType] = ("text.color", "axes.labelcolor", "xtick.color", "ytick.color")
STYLE: dict[RcKeyType, Any] = {
    **dict.fromkeys(INK, DRAWN["ink"]), "axes.edgecolor": DRAWN["faint"], "grid.color": DRAWN["line"],
    "grid.linewidth": 0.6, "axes.grid": True, "axes.axisbelow": True, "axes.spines.top": False,
    "axes.spines.right": False, "font.family": "sans-serif", "font.size": 9, "legend.frameon": False,
    "legend.fontsize": 8.5, "lines.linewidth": 1.2, "text.parse_math": False, "axes.unicode_minus": True,
    "svg.fonttype": "none", "svg.hashsalt": "ballscrew",
}  # fmt: skip


def style(dark: bool) -> str:
    """The colours as a style sheet has them."""
    return " ".join(f"--{name}: {pair[dark]};" for name, pair in COLOURS.items())


def in_colour(svg: str) -> str:
    """A drawing with the page's colours for the stand-ins."""
    for colour, name in STAND_INS.items():
        svg = svg.replace(colour, f"var(--{name})")
    return svg


class Sheet:
    """A figure under way; `picture` is it, once it is drawn."""

    def __init__(self, figure: Figure) -> None:
        self.figure = figure
        self.svg = ""

    def picture(self, caption: str) -> Picture:
        """It, with what it shows."""
        return Picture(self.svg, caption)


@contextmanager
def sheet(height: float) -> Iterator[Sheet]:
    """An empty figure, drawn at the end."""
    import matplotlib  # takes a third of a second
    from matplotlib.figure import Figure

    with matplotlib.rc_context(STYLE):
        drawn = Sheet(Figure((WIDTH, height), layout="constrained"))
        yield drawn
        text = io.StringIO()
        drawn.figure.savefig(text, format="svg", transparent=True, metadata={"Date": None})
        drawn.svg = _alone(in_colour(text.getvalue()))


def _alone(svg: str) -> str:
    """The drawing without the head of a file, its names its own among those of other drawings of a page."""
    prefix, svg = f"p{hashlib.sha256(svg.encode()).hexdigest()[:8]}-", svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'\bd="[^"]*"', lambda path: re.sub(r"(\.\d\d)\d+", r"\1", path[0]), svg)  # a hundredth of a point
    svg = re.sub(r'\bid="', f'id="{prefix}', svg)
    svg = re.sub(r'(<image [^>]*)\bid="[^"]*"', r"\1", svg)  # nobody asks for one, and alike ones have the same
    return re.sub(r'(url\(#|href="#)', rf"\1{prefix}", svg)


def shown(values: Array) -> Array:
    """Ticks to draw of a curve (K,): the lowest and highest of each of so many bins, the ends, and one in each gap."""
    is_known = np.isfinite(values)
    known, gaps = np.flatnonzero(is_known), np.flatnonzero(is_known[:-1] & ~is_known[1:]) + 1
    if len(known) <= 2 * BINS:
        return np.union1d(known, gaps)
    bins = np.array_split(known, BINS)
    most = [b[f(values[b])] for b in bins for f in (np.argmin, np.argmax)]
    return np.unique([known[0], known[-1], *most, *gaps])


def curve(axes: Axes, minutes: Array, values: Array, colour: str, label: str, sd: Array | None = None) -> None:
    """A line, and a band of two sd."""
    at = shown(values)
    axes.plot(minutes[at], values[at], color=DRAWN[colour], label=label)
    if sd is not None:
        ends = values[at] - 2 * sd[at], values[at] + 2 * sd[at]
        axes.fill_between(minutes[at], *ends, color=DRAWN[colour], alpha=0.25, linewidth=0, label="± 2 sd")


def dots(axes: Axes, minutes: Array, values: Array, colour: str, label: str) -> None:
    """Single values, evenly taken: their extremes alone would look like two curves."""
    known = np.flatnonzero(np.isfinite(values))
    at = known[:: -(-len(known) // DOTS) or 1]
    axes.plot(minutes[at], values[at], ".", color=DRAWN[colour], markersize=2.5, label=label)


def shade(axes: Axes, recording: Recording) -> None:
    """The drives, as grey ground; time in minutes below."""
    minutes = recording.time_s / 60
    for driving, ticks in phases(recording):
        if driving:
            begin = minutes[max(ticks[0] - 1, 0)]
            axes.axvspan(begin, minutes[ticks[-1]], color=DRAWN["shade"], zorder=0, linewidth=0)
    axes.set_xlim(minutes[0], minutes[-1])


def legend(axes: Axes, columns: int = 5) -> None:
    """What is what, above the axes."""
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=columns, borderaxespad=0.2, handlelength=1.5)
