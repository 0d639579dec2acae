"""Make the runs of this folder: finer physics than the model's, in steps of 50 ms.

element -> body -> sensor;   bodies lose heat to the air by h A (T - T_air) and emissivity sigma A (T^4 - T_air^4),
and warm each other the same two ways
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

STEP_S, ROW_S, ROWS = 0.05, 4.0, 420
POWER = np.array([0.016, 0.011])  # W per %
ELEMENT, BODY, SENSOR = 0.5, np.array([6.0, 6.0]), 0.3  # J/K
TO_BODY, TO_SENSOR = 0.12, 0.03  # W/K
AIR, AREA, SIGMA = 0.040, 1.2e-3, 5.67e-8  # W/K, m2, W/(m2 K4)
EMISSIVITY, FACING = 0.6, 0.2e-3  # of the surface; m2 that see each other
COUPLING = 0.022  # W/K through the board between the bodies
SCATTER_K = 0.05

RUNS = {  # heater: (from s, to s, %)
    "first.csv": ([(60, 800, 60)], []),
    "second.csv": ([], [(60, 800, 80)]),
    "both.csv": ([(60, 900, 40)], [(400, 1300, 70)]),
    "steps.csv": ([(60, 300, 70), (300, 600, 20), (1000, 1300, 50)], [(200, 500, 30), (700, 1100, 90)]),
}


def percent(steps: list[tuple[float, float, float]], t: float) -> float:
    """What a heater is set to at a time."""
    return sum(size for begin, end, size in steps if begin < t <= end)


def radiated(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """W/m2 from a to b, degC."""
    return EMISSIVITY * SIGMA * ((a + 273.15) ** 4 - (b + 273.15) ** 4)


def lived(first: list, second: list, seed: int) -> np.ndarray:
    """Rows of time, both heaters, both sensors and the air."""
    dice, start = np.random.default_rng(seed), 21.0 + 0.5 * seed
    element, body, sensor = np.full(2, start), np.full(2, start), np.full(2, start)
    rows = [[0.0, 0.0, 0.0, *sensor, start]]
    for row in range(1, ROWS):
        energy = np.zeros(2)
        for k in range(round(ROW_S / STEP_S)):
            t = (row - 1) * ROW_S + (k + 1) * STEP_S
            air = start + 0.4 * np.sin(2 * np.pi * t / 2400.0)
            set_to = np.array([percent(first, t), percent(second, t)])
            energy += set_to
            into_body, into_sensor = TO_BODY * (element - body), TO_SENSOR * (body - sensor)
            other = body[::-1]
            lost = AIR * (body - air) + AREA * radiated(body, np.full(2, air))
            lost += COUPLING * (body - other) + FACING * radiated(body, other)
            element = element + STEP_S / ELEMENT * (POWER * set_to - into_body)
            body = body + STEP_S / BODY * (into_body - into_sensor - lost)
            sensor = sensor + STEP_S / SENSOR * into_sensor
        rows.append([row * ROW_S, *(energy * STEP_S / ROW_S), *sensor, air])
    table = np.array(rows)
    table[:, 3:5] += dice.normal(0, SCATTER_K, table[:, 3:5].shape)
    return table


def main() -> None:
    """Write all runs beside this file."""
    for seed, (name, steps) in enumerate(RUNS.items()):
        np.savetxt(
            Path(__file__).parent / name, lived(*steps, seed), ["%d", "%.4g", "%.4g", "%.2f", "%.2f", "%.2f"], ",",
            header="t_s,heater_1,heater_2,T1,T2,air_C", comments="",
        )  # fmt: skip


if __name__ == "__main__":
    main()
