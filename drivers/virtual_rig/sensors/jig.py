"""Slow bodies around the screw: the probes' jigs, the super-Invar bar between them, the telemeter's circuit board."""

import math
from dataclasses import dataclass

from drivers.virtual_rig.population.constants import Jig as Build


@dataclass(frozen=True)
class Jig:
    """Temperatures of probes, bar and circuit board, degC"""

    probe: float
    bar: float
    board: float

    def after_tick(self, build: Build, ambient: float, seats: float, screw: float, turning: float) -> "Jig":
        """dT/dt = (T_target - T) / tau over 1 s; mean temperatures of seats and screw (degC), omega / omega_20."""
        board = ambient + build.board_self_heating + build.board_turning * turning
        return Jig(
            probe=_follow(self.probe, ambient + build.probe_follows * (seats - ambient), build.probe_time),
            bar=_follow(self.bar, ambient + build.bar_follows * (screw - ambient), build.bar_time),
            board=_follow(self.board, board, build.board_time),
        )


def _follow(value: float, target: float, tau: float) -> float:
    return target + (value - target) * math.exp(-1.0 / tau)
