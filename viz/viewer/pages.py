"""The tabs of a layout as the viewer reports it: what must be chosen to show each of them.

A layout is a mapping from blueprint paths ("/container/ID", "/view/ID", ...) to their components.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

Layout = dict[str, Any]


@dataclass(frozen=True)
class Page:
    """One innermost tab: its names from outside in, and for each container of tabs the child that it must show."""

    names: tuple[str, ...]
    chosen: tuple[tuple[str, str], ...]

    def show(self, layout: Layout) -> None:
        """Choose this page in the layout."""
        for container, child in self.chosen:
            layout[f"/{container}"]["ContainerBlueprint"]["active_tab"] = child


def pages_of(layout: Layout) -> list[Page]:
    """All pages, from left to right."""
    root = layout["/viewport"]["ViewportBlueprint"]["root_container"]
    return list(_pages(layout, f"container/{root}", Page((), ())))


def _pages(layout: Layout, container: str, outer: Page) -> Iterator[Page]:
    for child in layout[f"/{container}"]["ContainerBlueprint"]["contents"]:
        page = Page((*outer.names, _name(layout, child)), (*outer.chosen, (container, child)))
        if layout[f"/{child}"].get("ContainerBlueprint", {}).get("container_kind") == "Tabs":
            yield from _pages(layout, child, page)
        else:
            yield page


def _name(layout: Layout, path: str) -> str:
    about = layout[f"/{path}"]
    return str((about.get("ContainerBlueprint") or about["ViewBlueprint"])["display_name"])
