"""Where things sit on the rig: mm along the screw, from channel 1 at the free end towards the motor."""

import numpy as np

CHANNEL_SPACING_MM = (72.5, 54.5, 144.0, 144.0, 144.0, 144.0, 84.0, 30.0, 30.0, 24.0, 18.0, 15.5, 20.0, 55.5)
CHANNEL_MM = np.concatenate(([0.0], np.cumsum(CHANNEL_SPACING_MM)))
CHANNELS = CHANNEL_MM.size

SPAN_MM = (44.5, 980.0)  # the two discs between which the elongation is measured

SCREW_MM = (-60.0, 1030.0)  # the ends of the screw: the telemeter's head sits on the first, the coupling on the second

ANCHOR_BEARING_MM = 889.0

TABLE_MM = tuple(50.0 * i for i in range(9))  # positions of the table at which its error is kept as truth

NUT_ZERO_MM = 673.5  # nut centre at table position 0; the nut moves towards the free end as the position grows

LEAD_MM = 12.0
OMEGA_20 = 2.0 * np.pi * 20.0 / 60.0 / (LEAD_MM * 1e-3)  # 174.5 rad/s at 20 m/min, the reference of every speed law
OUTER_RADIUS_M = 0.020
BORE_RADIUS_M = 0.0085


def nut_centre_mm(position_mm: np.ndarray) -> np.ndarray:
    """x_nut = 673.5 - z   mm"""
    return NUT_ZERO_MM - position_mm
