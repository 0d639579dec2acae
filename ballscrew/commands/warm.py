"""ballscrew warm: compile the filter before it is needed."""

import click
import numpy as np

from ballscrew.options import terminal_options
from ballscrew.terminal import Terminal
from ballscrew.workspace import BUILT_IN
from estimator.batch import batch
from estimator.batch.replay import Replay
from estimator.record import Array, Recording
from estimator.rig import Rig
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig

ROOM_C = 20.0
TICKS = 8


@click.command("warm")
@terminal_options
def command(terminal: Terminal) -> None:
    """Compile the filter for this machine, once: the first command that needs it does so else, for some 15 s.

    `make` does it while it installs; after `pip install` it is yours to do, or to leave.
    """
    cold = batch.is_cold()
    terminal.say_if_compiling()
    rig, model = load_rig(BUILT_IN), load_model(BUILT_IN / "model.toml")
    replayed = Replay(model, rig, _standing(rig), None, lambda _: None)
    replayed.smoothed()
    assert replayed.trial is not None
    system = replayed.trial.pose(model).system
    batch.loglike(system), batch.score(system)
    terminal.say("the filter is compiled" if cold else "the filter was compiled already")
    terminal.json({"compiled": cold})


def _standing(rig: Rig) -> Recording:
    """A cold screw that stands still for some ticks: enough for every kind of array that a kernel takes."""
    time_s, channels = rig.tick_s * np.arange(1.0, TICKS + 1.0), np.full((TICKS, len(rig.names)), ROOM_C)
    inputs = {name: _still(signal.unit) for name, signal in rig.inputs.items()}
    cells = rig.the_screw().cells
    return Recording(
        "standing", time_s, channels, np.zeros_like(channels), inputs, np.zeros(TICKS), np.zeros((TICKS, cells))
    )


def _still(unit: str) -> Array:
    return np.full(TICKS, ROOM_C if unit == "degC" else 0.0)
