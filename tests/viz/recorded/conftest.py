"""A run that was filtered, and the file that it is saved to."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.viz_fake import fake_run
from viz.recorded.recorded import save
from viz.recorded.run import ReviewedRun

SECONDS = 700


@pytest.fixture(scope="package")
def run() -> ReviewedRun:
    return fake_run("FS-20", SECONDS)


@pytest.fixture(scope="package")
def saved(run: ReviewedRun, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs in one file."""
    path = tmp_path_factory.mktemp("viz") / "two.rrd"
    save(path, [run, replace(run, name="CS 2.5")], "# Summary\n\ngiven by the caller")
    return path
