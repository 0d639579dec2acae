"""How warm the screw is when a run begins: what it has grown by then against what it would be without heat."""

from dataclasses import dataclass

import numpy as np

from estimator.state.run import Run

SURROUNDINGS = ("ambient", "base")
SENSOR_K = 0.15  # a thermometer of the surroundings may be off against the screw's by so much


@dataclass(frozen=True)
class Warmth:
    """Growth of the measured span at the first sample since the screw was as cold as its surroundings, and its sd, um.

    counted  whether the elongation holds it, counted from the rig's zero_C
    """

    grown_um: float
    sd_um: float
    counted: bool

    @property
    def warm(self) -> bool:
        """Whether it has grown for certain: an elongation that counts from there lacks it."""
        return self.grown_um > 2.0 * self.sd_um

    @property
    def sentence(self) -> str:
        """What it means for who reads the elongation."""
        lacks = "" if self.counted else "; the elongation counts from there, unless rig.toml says zero_C"
        return f"began warm: about {self.grown_um:.0f} um grown already, +- {2.0 * self.sd_um:.0f} (2 sd){lacks}"


def warmth(run: Run) -> Warmth | None:
    """The warmth of a run at its start, None where nothing tells how warm the surroundings are.

    c (z - T),   T the mean of air and base, which in a steady rig are as warm as the screw whatever their sensors show;
    var = c' P c + sum(c)^2 (SENSOR_K^2 + d^2),   d half of what air and base differ by
    """
    shown = [run.sample.inputs.get(name, np.nan) - run.start.zero_K.get(name, 0.0) for name in SURROUNDINGS]
    around = [celsius for celsius in shown if np.isfinite(celsius)]
    if not around or not run.view.has_span:
        return None
    at, growth = run.state.temperatures, run.view.growth
    apart = np.ptp(around) / 2.0
    variance = growth @ run.P[at, at] @ growth + growth.sum() ** 2 * (SENSOR_K**2 + apart**2)
    grown_um, counted = float(growth @ (run.x[at] - np.mean(around))), run.forcing.rig.zero_C is not None
    return Warmth(grown_um, float(np.sqrt(variance)), counted)
