"""What all tests of views share: strict mode, and the patience of tests in place of the views' own."""

from collections.abc import Iterator

import pytest
import rerun as rr

from tests.processes import PATIENCE_S
from viz.live import outlet
from viz.viewer import viewer, web


@pytest.fixture(scope="session", autouse=True)
def _strict() -> Iterator[None]:
    """A value that the format does not know raises."""
    rr.set_strict_mode(True)
    yield
    rr.set_strict_mode(False)


@pytest.fixture(scope="session", autouse=True)
def _patient() -> Iterator[None]:
    """On a machine with much else to do a viewer takes its time, and that is no fault."""
    with pytest.MonkeyPatch.context() as patch:
        for module, name in ((outlet, "FLUSH_S"), (outlet, "CLOSE_S"), (viewer, "START_S"), (web, "START_S")):
            patch.setattr(module, name, PATIENCE_S)
        yield
