"""The experiment as the operator runs it: rest, drive until the elongation nears 50 um, stop for an hour, again."""

import difflib
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drivers.virtual_rig.machine.geometry import OMEGA_20
from drivers.virtual_rig.machine.heat import ThermalRig, step_middles
from drivers.virtual_rig.machine.motion import Drive, Stroke, TableMotion, Travel
from drivers.virtual_rig.machine.screw import Growths
from drivers.virtual_rig.sensors.jig import Jig
from drivers.virtual_rig.sensors.probes import OVER_RANGE, Gauge, Probes, Reading
from drivers.virtual_rig.sensors.truth import Truth

# Table positions between which the table moves, mm
PATTERNS = {"FS": (0.0, 400.0), "CS": (130.0, 243.0), "ES": (202.0, 315.0)}
SPEEDS = ("20", "10", "5", "2.5")
EXPERIMENTS = tuple(f"{pattern}-{speed}" for pattern in PATTERNS for speed in SPEEDS)

# m/min; beyond the fastest, the short strokes hold no constant speed long enough for a peak to be held
SLOWEST, FASTEST = 1.0, 25.0
REST_S = 20.0
TARGET_UM = 49.5  # seen by the operator; the table then finishes its stroke
Progress = Callable[[float, float], None]  # called each rig minute with the rig time (s) and the elongation (um)


def stroke(name: str) -> Stroke:
    """The stroke of an experiment; any speed between 1 and 25 m/min may follow the pattern."""
    pattern, _, text = name.partition("-")
    try:
        (low, high), speed = PATTERNS[pattern], float(text)
    except (KeyError, ValueError):
        near = difflib.get_close_matches(name.upper(), EXPERIMENTS, n=1, cutoff=0.0)[0]
        raise ValueError(f"unknown experiment {name!r}; did you mean {near!r}?") from None
    if not SLOWEST <= speed <= FASTEST:
        raise ValueError(f"experiment {name!r}: the speed must lie between {SLOWEST:g} and {FASTEST:g} m/min")
    return Stroke(low, high, speed * 1000.0 / 60.0)


@dataclass(frozen=True)
class Plan:
    """How long to drive, to stop, how often, and when to break off."""

    max_drive_s: float
    stop_s: float
    cycles: int
    seconds: float | None


class Experiment:
    """One run under way: the rig, the operator's eye on the held readings, and what has happened so far."""

    def __init__(
        self, rig: ThermalRig, probes: Probes, travel: Travel, growths: Growths, draw: np.random.Generator
    ) -> None:
        self.rig, self.probes, self.travel, self.draw = rig, probes, travel, draw
        self.growths, start = growths, rig.weather.start
        self.jig = Jig(start, start, start + rig.machine.jig.board_self_heating)
        self.rows: list[tuple[Any, ...]] = []
        self.held: list[tuple[float, float, float, int]] = []
        self.start_at, self.cycles_done = REST_S, 0

    def run(self, plan: Plan, progress: Progress | None) -> None:
        """From the first sample to the end of the last stop."""
        self._record(0.0)
        t = 0.0
        while self.cycles_done < plan.cycles or t < self.start_at:
            if t >= (plan.seconds if plan.seconds is not None else math.inf):
                break
            self._act(t, plan)
            self._tick(t)
            t += 1.0
            self._watch(t, plan)
            if progress is not None and t % 60 == 0:
                progress(t, self.rows[-1][2] + self.rows[-1][3])

    @property
    def _driving(self) -> bool:
        return len(self.travel.drives) > self.cycles_done

    def _act(self, t: float, plan: Plan) -> None:
        """The operator starts a drive when it is time."""
        if not self._driving and t >= self.start_at and self.cycles_done < plan.cycles:
            from_low = self.travel.drives[-1].ends_low if self.travel.drives else True
            self.travel = replace(self.travel, drives=(*self.travel.drives, Drive(self.travel.stroke, t, from_low)))

    def _tick(self, t: float) -> None:
        motion = self.travel.at(step_middles(t, self.travel.moves_between(t, t + 1.0)))
        self.rig.tick(t, motion)
        self._warm_jig(t, motion)
        self._record(t + 1.0)

    def _warm_jig(self, t: float, motion: TableMotion) -> None:
        seats = (self.rig.anchor_seat + self.rig.free_seat) / 2.0
        turning = float(motion.omega.mean()) / OMEGA_20
        self.jig = self.jig.after_tick(
            self.rig.machine.jig, self.rig.weather.ambient(t), seats, float(self.rig.mean.mean()), turning
        )

    def _record(self, t: float) -> None:
        rig, weather = self.rig, self.rig.weather
        rise = rig.mean - weather.start
        motor, free = float(self.growths.motor @ rise), float(self.growths.free @ rise)
        nut = rig.nut
        around = (weather.ambient(t), weather.base(t), *rig.brackets, nut, self.jig.probe, self.jig.bar)
        table = self.growths.table @ rise
        self.rows.append((t, rig.at_channels, motor, free, table, around, self.jig.board, rig.anchor_seat, *rig.torque))

    def _watch(self, t: float, plan: Plan) -> None:
        """The operator reads what was held and ends the drive with the stroke under way."""
        if not self._driving:
            return
        drive = self.travel.drives[-1]
        near = self._hold(drive, t)
        if math.isinf(drive.strokes) and (near or t - drive.start_s >= plan.max_drive_s):
            drive = replace(drive, strokes=drive.stroke_ends_by(t))
            self.travel = replace(self.travel, drives=(*self.travel.drives[:-1], drive))
        if t >= drive.stop_s:
            self.cycles_done += 1
            self.start_at = math.ceil(drive.stop_s + plan.stop_s)

    def _hold(self, drive: Drive, t: float) -> bool:
        """Take the stroke centres of the last second; is the elongation near its target, or out of range?"""
        near = False
        for centre in drive.centres(t - 1.0, t):
            reading = self.probes.held(self._gauge(centre), self.draw)
            self.held.append((centre, *(column[0] for column in reading)))
            first = self.held[0]
            seen = (reading.a1b1[0] + reading.a2b2[0] - first[1] - first[2]) / 2.0
            near |= bool(seen >= TARGET_UM or reading.state[0] == OVER_RANGE)
        return near

    def _gauge(self, t: float) -> Gauge:
        """What the probes follow, between the last two ticks."""
        gauge = Truth.of([self.rows[0], *self.rows[-2:]]).gauge
        late = t - self.rows[-2][0]
        return Gauge(*(column[1:2] + late * (column[2:3] - column[1:2]) for column in gauge))

    @property
    def readings(self) -> tuple[np.ndarray, Reading]:
        """Stroke centres (m,) and what was held there."""
        columns = np.array(self.held, dtype=float).reshape(-1, 4).T
        return columns[0], Reading(columns[1], columns[2], columns[3].astype(int))
