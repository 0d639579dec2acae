"""What counts as worse than a kept figure."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .measure import GROUPS, Figures, Key

Tolerance = Mapping[str, Mapping[str, float]]  # by figure: of single channels where it is under "channel", else "all"

TOLERANCE: Tolerance = {
    "all": {
        "nis": 0.05, "whiteness": 0.03, "in_2sd": 0.01, "blind_nis": 0.1, "blind_in_2sd": 0.02,
        "one_step": 0.02, "ahead": 0.05, "open_loop": 0.05, "band": 0.05, "cooldown_max": 0.1, "truth_in_2sd": 0.02,
    },
    "channel": {"nis": 0.1, "blind_nis": 0.4, "blind_in_2sd": 0.1},
}  # fmt: skip


@dataclass(frozen=True)
class Change:
    """A figure that differs by more than its tolerance; `now` is None where it is not measured any more."""

    key: Key
    kept: float
    now: float | None
    tolerance: str


def worse(kept: Figures, now: Figures, tolerance: Tolerance = TOLERANCE) -> list[Change]:
    """The figures further from what they should be than the kept ones, by more than their tolerance."""
    return [
        _change(key, kept[key], now.get(key), tolerance)
        for key in kept
        if key not in now or badness(key, now[key]) > badness(key, kept[key]) + _allowed(key, tolerance)
    ]


def better(kept: Figures, now: Figures, tolerance: Tolerance = TOLERANCE) -> list[Change]:
    """The figures nearer to what they should be, by more than their tolerance."""
    both = {key: now[key] for key in kept if key in now}
    return [_change(w.key, kept[w.key], now[w.key], tolerance) for w in worse(both, kept, tolerance)]


def badness(key: Key, value: float) -> float:
    """How far a figure is from what it should be: NIS from 1 (half is as far as twice), coverage from 95 %."""
    figure = key[2]
    if figure.endswith("in_2sd"):
        return abs(value - 0.95)
    if not _is_ratio(figure):
        return abs(value)
    size = math.log(max(value, 1e-9))
    return abs(size) if figure.endswith("nis") else size


def table(found: Sequence[Change]) -> str:
    """Lines of text below a head."""
    head = ("figure", "recording", "channel", "kept", "now", "tolerance")
    rows = [
        (w.key[2], w.key[0], w.key[1], digits(w.kept), "none" if w.now is None else digits(w.now), w.tolerance)
        for w in found
    ]
    wide = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    return "\n".join("  ".join(map(str.ljust, row, wide)).rstrip() for row in (head, *rows))


def digits(value: float) -> str:
    """Four digits, as TOML takes a float."""
    text = f"{value:.4g}"
    return text if set(text) & set(".e") else f"{text}.0"


def _change(key: Key, kept: float, now: float | None, tolerance: Tolerance) -> Change:
    allowed = _allowed(key, tolerance)
    return Change(key, kept, now, f"{allowed:.0%}" if _is_ratio(key[2]) else f"{allowed:g}")


def _allowed(key: Key, tolerance: Tolerance) -> float:
    figure = key[2].removesuffix("_K").removesuffix("_um")
    rows = [{}, tolerance.get("channel", {})][key[1] not in GROUPS], tolerance.get("all", {}), TOLERANCE["all"]
    return next(float(row[figure]) for row in rows if figure in row)


def _is_ratio(figure: str) -> bool:
    """Whether the tolerance is a share of the figure: of NIS and of every error."""
    return figure.endswith(("nis", "_K", "_um"))
