"""Which rig folder is judged: the paper's, or the one of --rig-folder PATH."""

from pathlib import Path

import pytest

from estimator.errors import SetupError

from .kept import Kept, kept_path, read
from .measure import PAPER, Folder


def pytest_addoption(parser: pytest.Parser) -> None:
    """`pytest tests/tuning/test_tuning.py --rig-folder PATH`."""
    parser.addoption("--rig-folder", type=Path, default=PAPER, metavar="PATH", help="judge this rig and its kept.toml")


def rig_folder(config: pytest.Config) -> Path:
    """The folder asked for; in a run of all tests the option does not exist."""
    return config.getoption("rig_folder", PAPER)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """A test for each recording with kept figures."""
    if "judged" in metafunc.fixturenames:
        try:
            kept = read(kept_path(rig_folder(metafunc.config)))
        except SetupError as error:
            raise pytest.UsageError(str(error)) from None
        metafunc.parametrize("judged", kept.recordings)


@pytest.fixture(scope="session")
def paper() -> Folder:
    """The paper's rig folder."""
    return Folder(PAPER)


@pytest.fixture(scope="session")
def folder(pytestconfig: pytest.Config, paper: Folder) -> Folder:
    """The folder that is judged."""
    path = rig_folder(pytestconfig)
    return paper if path.resolve() == PAPER else Folder(path)


@pytest.fixture(scope="session")
def kept(folder: Folder) -> Kept:
    """Its kept figures."""
    return read(kept_path(folder.path))
