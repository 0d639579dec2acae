"""The page's colours, light and dark, by name. Pictures are drawn in stand-ins for them."""

from __future__ import annotations

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


def style(dark: bool) -> str:
    """The colours as a style sheet has them."""
    return " ".join(f"--{name}: {pair[dark]};" for name, pair in COLOURS.items())


def in_colour(svg: str) -> str:
    """A drawing with the page's colours for the stand-ins."""
    for colour, name in STAND_INS.items():
        svg = svg.replace(colour, f"var(--{name})")
    return svg
