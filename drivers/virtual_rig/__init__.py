"""The rig in software: finer physics than any estimator's, its sensors with their errors, its frames.

It stands for the real machine, so it shares nothing with the code that is judged on it.
In the order to read them: simulation, protocol, run, dice; then population/, machine/, sensors/
and frames/.
"""

from drivers.virtual_rig.frames.frames import frame_table
from drivers.virtual_rig.frames.player import play
from drivers.virtual_rig.frames.recording import write
from drivers.virtual_rig.protocol import EXPERIMENTS
from drivers.virtual_rig.run import Run
from drivers.virtual_rig.simulation import simulate

__all__ = ["EXPERIMENTS", "Run", "frame_table", "play", "simulate", "write"]
