"""Messages of a bus that should have come: each has its cycle time in the DBC, and three of them are a time-out."""

from collections.abc import Iterator

from drivers.decode.dbc import Layout

CYCLES = 3.0
PATIENCE_S = 60.0  # for what has no cycle time


class Missing:
    """When each cyclic message was last heard, s on the rig's clock."""

    def __init__(self, messages: list[Layout], tick_s: float) -> None:
        self._cyclic = {(m.id, m.extended): m for m in messages if m.cycle_s}
        self._awaited = {(m.id, m.extended): m for m in messages if not m.cycle_s}
        self._least_s = 2.5 * tick_s
        self._last: dict[tuple[int, bool], float] = {}

    def never(self, now_s: float) -> list[str]:
        """Messages without a cycle time that have not come since the start: told once."""
        if now_s < PATIENCE_S:
            return []
        names = [f"{message.name} (0x{message.id:X})" for message in self._awaited.values()]
        self._awaited = {}
        return names

    @property
    def count(self) -> int:
        """How many messages are waited for."""
        return len(self._cyclic)

    def heard(self, can_id: int, extended: bool, now_s: float) -> None:
        """A frame has come."""
        self._awaited.pop((can_id, extended), None)
        if (can_id, extended) in self._cyclic:
            self._last[can_id, extended] = now_s

    def since(self, now_s: float) -> Iterator[tuple[str, float]]:
        """Messages that are missing, and when each was last heard; one that never came counts from the first frame."""
        for key, message in self._cyclic.items():
            last = self._last.get(key, 0.0)
            if now_s - last > max(CYCLES * message.cycle_s, self._least_s):
                yield f"{message.name} (0x{message.id:X})", last
