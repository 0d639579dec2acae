"""Make runs of this folder: 200 slices of 2 mm, stepped on by 12.5 ms."""

from __future__ import annotations

from pathlib import Path

import numpy as np

STEP_S, ROW_S, SLICES, LENGTH, OUTER = 0.0125, 5.0, 200, 0.4, 0.02
DENSITY, HEAT_CAPACITY, CONDUCTIVITY = 2700.0, 900.0, 172.0
AIR, SHARE, CHILLED = 9.0, 0.95, 1.2  # W/(m2 K), 1, W/K
LAG_S, BLOCK_S, SCATTER_K, SWING_K, SWING_S = 4.0, 80.0, 0.05, 0.25, 3000.0
PLACES = np.array([0.040, 0.075, 0.120, 0.170, 0.225, 0.280, 0.330, 0.375])

RUNS = {  # heater: (from s, W), chiller: (from s, degC), minutes
    "slow.csv": ([(300, 6.0), (1500, 0.0)], [(0, 20.5)], 45),
    "pulses.csv": ([(60, 10.0), (600, 0.0), (1200, 10.0), (1740, 0.0)], [(900, 14.0)], 45),
}


def latest(steps: list[tuple[float, float]], t: float, before: float) -> float:
    """What was set last at a time."""
    return next((size for begin, size in reversed(steps) if t > begin), before)


def lived(heater: list, chiller: list, minutes: float, seed: int) -> np.ndarray:
    """Rows of time, heater, chiller, air and eight thermocouples."""
    dice, start, dx = np.random.default_rng(seed), 21.0 + 0.5 * seed, LENGTH / SLICES
    area, around = np.pi / 4 * OUTER**2, np.pi * OUTER * dx
    x = (np.arange(SLICES) + 0.5) * dx
    into, capacity = (x < 0.030) / np.sum(x < 0.030), DENSITY * HEAT_CAPACITY * area * dx
    rod, seen, block, air = np.full(SLICES, start), np.full(8, start), start, start
    rows = [[0.0, 0.0, block, air, *seen]]
    for row in range(1, round(minutes * 60 / ROW_S) + 1):
        energy = 0.0
        for k in range(round(ROW_S / STEP_S)):
            t = (row - 1) * ROW_S + (k + 1) * STEP_S
            power = latest(heater, t, 0.0)
            air = start + SWING_K * np.sin(2 * np.pi * t / SWING_S)
            block += STEP_S / BLOCK_S * (latest(chiller, t, start) - block)
            flow = CONDUCTIVITY * area / dx * -np.diff(rod, prepend=rod[0], append=rod[-1])
            heat = flow[:-1] - flow[1:] + SHARE * power * into - AIR * around * (rod - air)
            heat[-1] -= CHILLED * (rod[-1] - block)
            rod = rod + STEP_S / capacity * heat
            seen = seen + STEP_S / LAG_S * (np.interp(PLACES, x, rod) - seen)
            energy += power * STEP_S
        rows.append([row * ROW_S, energy / ROW_S, block, air, *seen])
    table = np.array(rows)
    table[:, 4:] += dice.normal(0, SCATTER_K, table[:, 4:].shape)
    table[:, 2:4] += dice.normal(0, 0.01, table[:, 2:4].shape)
    return table


def main() -> None:
    """Write the runs beside this file."""
    for seed, (name, (heater, chiller, minutes)) in enumerate(RUNS.items()):
        columns = ["t_s", "heater_W", "chiller_C", "air_C", *(f"TC{i}" for i in range(1, 9))]
        path, table = Path(__file__).parent / name, lived(heater, chiller, minutes, seed)
        np.savetxt(path, table, ["%d", "%.4g", *["%.2f"] * 10], ",", header=",".join(columns), comments="")


if __name__ == "__main__":
    main()
