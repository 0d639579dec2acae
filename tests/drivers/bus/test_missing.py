"""Messages that should have come: three of their cycles are a time-out, but at least two and a half ticks."""

import pytest

from drivers.bus.missing import Missing
from drivers.decode.dbc import Layout

FAST = Layout("Fast", 0x230, False, 8, {}, cycle_s=0.01)
SLOW = Layout("Slow", 0x240, False, 8, {}, cycle_s=1.0)
RARE = Layout("Rare", 0x250, False, 8, {})


@pytest.mark.parametrize(("tick_s", "fast_s", "slow_s"), [(0.1, 0.25, 3.0), (1.0, 2.5, 3.0), (5.0, 12.5, 12.5)])
def test_what_is_missing_and_since_when(tick_s: float, fast_s: float, slow_s: float) -> None:
    missing = Missing([FAST, SLOW, RARE], tick_s)
    assert missing.count == 2
    for message in (FAST, SLOW, RARE):
        missing.heard(message.id, False, 100.0)
    missing.heard(SLOW.id, True, 200.0)  # another message
    assert not list(missing.since(100.0 + min(fast_s, slow_s)))
    assert ("Fast (0x230)", 100.0) in list(missing.since(100.01 + fast_s))
    assert ("Slow (0x240)", 100.0) not in list(missing.since(100.0 + slow_s))
    assert ("Slow (0x240)", 100.0) in list(missing.since(100.01 + slow_s))


def test_what_has_no_cycle_and_never_came_is_told_once() -> None:
    missing = Missing([FAST, RARE], 1.0)
    assert missing.never(59.0) == []
    assert missing.never(61.0) == ["Rare (0x250)"]
    assert missing.never(62.0) == []
    missing = Missing([FAST, RARE], 1.0)
    missing.heard(RARE.id, False, 10.0)
    assert missing.never(61.0) == []
