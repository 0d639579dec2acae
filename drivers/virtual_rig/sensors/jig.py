"""Slow bodies around the screw: the probes' jigs, the super-Invar bar between them, the telemeter's circuit board."""

import math
from dataclasses import dataclass

PROBE_FOLLOWS = 0.5  # share of the bearing seats' rise that reaches the probes beside them
PROBE_S = 600.0
BAR_FOLLOWS = 0.4  # share of the screw's mean rise that reaches the bar along it
BAR_S = 1500.0
BOARD_SELF_HEATING = 6.0  # K above the air, at rest
BOARD_WHILE_TURNING = 10.0  # K more at 20 m/min, from the rotary head
BOARD_S = 900.0


@dataclass(frozen=True)
class Jig:
    """Temperatures of probes, bar and circuit board, degC"""

    probe: float
    bar: float
    board: float

    def after_tick(self, ambient: float, seats: float, screw: float, turning: float) -> "Jig":
        """dT/dt = (T_target - T) / tau over 1 s; mean temperatures of seats and screw (degC), omega / omega_20."""
        return Jig(
            probe=_follow(self.probe, ambient + PROBE_FOLLOWS * (seats - ambient), PROBE_S),
            bar=_follow(self.bar, ambient + BAR_FOLLOWS * (screw - ambient), BAR_S),
            board=_follow(self.board, ambient + BOARD_SELF_HEATING + BOARD_WHILE_TURNING * turning, BOARD_S),
        )


def _follow(value: float, target: float, tau: float) -> float:
    return target + (value - target) * math.exp(-1.0 / tau)
