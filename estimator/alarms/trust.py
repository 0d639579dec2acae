"""Whether a control may rely on the estimate at this moment."""

from dataclasses import dataclass
from math import ceil

import numpy as np

from estimator.faults.fault import ELSEWHERE
from estimator.faults.travel import Travel
from estimator.inputs.phase import turns
from estimator.record import Sample
from estimator.rig import Rig
from estimator.step import Mode, Step

FEW_S = 5.0  # with too few thermometers
DRIVE_S = (3.0, 1.5)  # without news of the drive, at rest and moving: it stops within a tick, then is heard each second
DISPLACEMENT_S = 600.0
SHARE = 0.25  # of the thermometers, that are too few
UNSURE_UM = 0.5  # that the estimate may be off by for what may drift, or heat that the model lacks
STEADY_S = 3.0  # without a reason to the contrary, until an estimate that was not to be relied on is so again
NO_ESTIMATE = "no estimate yet"
UNSURE = f"heat that the model lacks, or a drift, may matter by more than {UNSURE_UM:g} um"


class Watch:
    """When things were last heard of, s on the rig's clock."""

    def __init__(self, rig: Rig, thermometers: int | None = None) -> None:
        """`thermometers` are to be fused; by default all of the rig."""
        self.least = max(1, ceil(SHARE * (len(rig.thermometers) if thermometers is None else thermometers)))
        self.needs_drive = "speed" in rig.inputs
        self._heat = rig.is_thermometer
        self._enough = self._displacement = self._drive = -np.inf
        self._moving = self._started = self._diverged = self._elsewhere = self._unsure = False
        self._why, self._doubted_s = tuple[str, ...](), -np.inf
        self._travel = Travel(rig)

    def drive(self, now_s: float) -> None:
        """A frame of the drive has come."""
        self._drive = now_s

    def tick(self, sample: Sample, step: Step, diverged: bool) -> None:
        """A tick has closed."""
        self._started, self._diverged = step.mode != Mode.INIT, diverged
        self._moving, self._elsewhere = bool(turns(sample.omega)), step.shift_mm != 0.0
        self._unsure = bool(step.unsure_um > UNSURE_UM)
        self._travel.step(sample)
        if step.fused[self._heat].sum() >= self.least:
            self._enough = step.time_s
        if step.fused[~self._heat].any():
            self._displacement = step.time_s

    def trust(self, now_s: float) -> "Trust":
        """What can be said at a time on the rig's clock."""
        few = now_s - self._enough > FEW_S
        why = []
        if not self._started:
            why.append(NO_ESTIMATE)
        elif few:
            why.append(f"fewer than {self.least} thermometers for {FEW_S:g} s")
        if self.needs_drive and now_s - self._drive > DRIVE_S[self._moving]:
            why.append("no news of the drive")
        if self._travel.lately:
            why.append(self._travel.lately)
        if self._elsewhere:
            why.append(ELSEWHERE)
        if self._unsure:
            why.append(UNSURE)
        if self._diverged:
            why.append("rig and model part")
        lasting = self._lasting(tuple(why), now_s)
        return Trust(lasting, now_s - self._displacement > DISPLACEMENT_S, few, self._diverged)

    def _lasting(self, why: tuple[str, ...], now_s: float) -> tuple[str, ...]:
        """Reasons at a time, and those just gone for some seconds: an estimate at a limit would flicker."""
        if why:
            self._why, self._doubted_s = why, now_s
        elif now_s - self._doubted_s >= STEADY_S or NO_ESTIMATE in self._why:
            self._why = ()
        return self._why


@dataclass(frozen=True)
class Trust:
    """Why the estimate is not to be relied on; empty where it is. The rest are flags of the frames that are sent.

    began_warm  the elongation counts from a warm screw
    """

    why: tuple[str, ...] = (NO_ESTIMATE,)
    displacement_stale: bool = True
    telemeter_stale: bool = True
    diverged: bool = False
    began_warm: bool = False

    @property
    def valid(self) -> bool:
        """Whether it may be used."""
        return not self.why
