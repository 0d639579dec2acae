"""The telemeter: 15 thermocouples on the bore wall and one on the circuit board, read in steps of 0.01 K."""

from dataclasses import dataclass

import numpy as np

from drivers.virtual_rig.dice import dice
from drivers.virtual_rig.machine.flows import recall
from drivers.virtual_rig.machine.geometry import CHANNELS
from drivers.virtual_rig.machine.planted import Strengths
from drivers.virtual_rig.population.constants import Sensors
from drivers.virtual_rig.population.draw import scattered_lags

NOISE_K = 0.02
OFFSET_K = 0.025
STEP_K = 0.01

EXTRA_LAG_S = 15.0
EXTRA_BOARD_DRIFT = 0.05  # K per K, planted
FAULTY_OFFSET_K = 0.3
FAULTY_GAIN = 0.05
WARM_CHANNELS = (2, 4, 5, 6, 12)  # channels that warm in every experiment: a wrong gain shows there


@dataclass(frozen=True)
class Telemeter:
    """Errors of the channels; arrays (15,)"""

    lag_s: np.ndarray
    offset: np.ndarray
    late_offset: np.ndarray
    gain: np.ndarray
    board_drift: float
    noise: float
    places: dict[str, float]

    def read(self, bore: np.ndarray, board: np.ndarray, moved: np.ndarray, draw: np.random.Generator) -> np.ndarray:
        """What the channels show, degC, in steps of 0.01 K: (n, 15)

        y = T0 + gain (lagged T - T0) + offset + drift (T_board - T_board0) + noise; `moved` (n,): the screw has turned
        """
        lagged = np.column_stack([lagging(column, tau) for column, tau in zip(bore.T, self.lag_s, strict=True)])
        shown = bore[0] + self.gain * (lagged - bore[0]) + self.offset + self.late_offset * moved[:, None]
        shown += self.board_drift * (board - board[0])[:, None]
        return quantised(shown + self.noise * draw.standard_normal(shown.shape))


def telemeter(seed: int, strength: Strengths, sensors: Sensors) -> Telemeter:
    """The telemeter of this seed's rig; its channels stay the same from run to run."""
    draw, base = dice(seed, "channels"), strength["thermometers"]
    of_seed = scattered_lags(sensors, draw)
    nominal = np.array(sensors.lags) if sensors.lags else of_seed
    offset = draw.uniform(-OFFSET_K, OFFSET_K, CHANNELS)
    shifted, misjudged = int(draw.integers(2, CHANNELS)), int(draw.choice(WARM_CHANNELS))
    numbers = np.arange(1, CHANNELS + 1)
    places = {"channel_offset": float(shifted), "channel_gain": float(misjudged)}
    return Telemeter(
        lag_s=base * nominal + EXTRA_LAG_S * strength["sensor_lag"],
        offset=base * offset,
        late_offset=FAULTY_OFFSET_K * strength["channel_offset"] * (numbers == shifted),
        gain=1.0
        + base * (np.array(sensors.gains) - 1.0)
        + FAULTY_GAIN * strength["channel_gain"] * (numbers == misjudged),
        board_drift=base * sensors.board_drift + EXTRA_BOARD_DRIFT * strength["board_drift"],
        noise=base * NOISE_K,
        places={name: channel for name, channel in places.items() if strength[name]},
    )


def lagging(spot: np.ndarray, tau: float) -> np.ndarray:
    """tau dy/dt + y = u from equilibrium, u straight between its 1 s samples: (n,) K

    y+ = a y + (1 - b) u+ + (b - a) u,   a = exp(-1/tau),  b = tau (1 - a)
    """
    if tau <= 0.0:
        return spot
    a = np.exp(-1.0 / tau)
    b = tau * (1.0 - a)
    rise = spot - spot[0]
    return spot[0] + recall(a, 1.0 - b, b - a, rise)


def quantised(temperature: np.ndarray) -> np.ndarray:
    """In steps of 0.01 K, as the telemeter sends it."""
    return np.round(temperature / STEP_K) * STEP_K
