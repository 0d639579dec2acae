"""The rig that ships with the project: its models, and recordings of it."""

from pathlib import Path

from drivers.recordings import read_recording
from estimator.model import Model
from estimator.record import Recording
from estimator.rig import Rig
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig

FOLDER = Path(__file__).parents[1] / "recordings"


def rig() -> Rig:
    """The paper's rig."""
    return load_rig(FOLDER)


def model(name: str = "model") -> Model:
    """The model fitted to it; "base" is the one of a machine without what is hidden."""
    return load_model(FOLDER / f"{name}.toml")


def path_of(name: str) -> Path:
    """The log of an experiment."""
    return FOLDER / f"{name}.blf"


def recording(name: str) -> Recording:
    """An experiment, as ticks."""
    return read_recording(path_of(name), rig())
