"""What is said of several recordings together."""

from types import SimpleNamespace

import numpy as np
import pytest

from ballscrew.report.review_report import parts

RIG = SimpleNamespace(tick_s=1.0)


def reviewed(name: str, began_s: float | None) -> SimpleNamespace:
    """Of a recording of 100 s."""
    return SimpleNamespace(recording=SimpleNamespace(name=name, began_s=began_s, time_s=np.arange(101.0)))


@pytest.mark.parametrize(
    ("began_s", "said"),
    [
        ((1e9, 1e9 + 101.0), "b goes on where a ends: "),
        ((1e9 + 101.0, 1e9), "a goes on where b ends: "),
        ((1e9, 1e9 + 101.0, 1e9 + 204.0), "b goes on where a ends, and 1 more so: "),
        ((1e9, 1e9), ""),
        ((1e9, 1e9 + 3600.0), ""),
        ((None, 1e9), ""),
    ],
)
def test_parts_of_one_recording_are_told(began_s, said):
    sentences = parts([reviewed(name, at_s) for name, at_s in zip("abc", began_s, strict=False)], RIG)
    assert [sentence.startswith(said) and "--join" in sentence for sentence in sentences] == [True] * bool(said)
