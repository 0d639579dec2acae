"""A run that nothing is wrong with, for what is put into it."""

from collections.abc import Callable

import pytest

from drivers.recordings import read_recording
from drivers.virtual_rig import simulate, write
from estimator.record import Recording


@pytest.fixture(scope="session")
def strokes(paper, tmp_path_factory) -> Callable[[int], Recording]:
    """strokes(seconds): four minutes of strokes, and then rest, on the machine of the recordings."""

    def of(seconds: int) -> Recording:
        log = write(simulate("FS-20", seed=101, seconds=seconds), tmp_path_factory.mktemp("rig") / "a.log")
        return read_recording(log, paper[0])

    return of
