"""What a state beside a reading says: that it is wrong, or only which reading it is."""

import numpy as np
import pytest

from drivers.decode.dbc import Bits, Condition, Layout
from drivers.decode.sources import Source
from drivers.frames import Tally, words_of
from estimator.rig import Channel


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("Rest", "other state Rest d"),
        ("centre", "other state centre d"),
        ("AxisMoving", "other state AxisMoving d"),
        ("OverRange", "flagged OverRange d"),
        ("Invalid", "flagged Invalid d"),
    ],
)
def test_a_state_that_selects_is_no_fault(text: str, reason: str) -> None:
    state, value = Bits("State", 0, 8, texts={0: "Drive", 1: text}), Bits("Value", 8, 8)
    layout = Layout("Length", 0x100, False, 2, {"State": state, "Value": value})
    source = Source("d", Channel(unit="um"), layout, (value,), valid=Condition("Length", state, "=", 0.0))
    data = np.zeros((4, 8), np.uint8)
    data[:, 0], data[:, 1] = [0, 1, 1, 0], 7
    tally = Tally()
    use, _ = source.read(words_of(data), np.arange(4.0), 1.0, tally)
    assert use.tolist() == [True, False, False, True]
    assert tally.counts() == {reason: 2}
