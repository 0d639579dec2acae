"""Doubts about the displacement: repeated, or of another sign or size than the screw can grow by its warming."""

from collections.abc import Iterator

import numpy as np

from ballscrew.doubts.doubt import Case, Doubt
from ballscrew.new_rig.growth import held

_CLEAR = 0.8  # correlation with the warming
_WARMED_K, _FEW = 1.0, 10
_TIMES = 4.0  # more or less than the screw can grow
NAMES = ("displacement", "displacement_direct")


def growth(case: Case) -> Iterator[Doubt]:
    """Each reading of the growth against the mean rise of the thermometers."""
    screw = case.rig.screw
    if screw is None:
        return
    expected = screw.expansion * (screw.span_mm[1] - screw.span_mm[0]) * 1e3  # um/K
    for name in NAMES:
        in_table = "channels" if name in case.rig.channels else "inputs"
        known = np.isfinite(value := _reading(case, name)) & np.isfinite(case.warmth)
        if known.sum() < _FEW or np.ptp(case.warmth[known]) < _WARMED_K or not np.ptp(value[known]):
            continue
        fit = float(np.corrcoef(case.warmth[known], value[known])[0, 1])
        slope = float(np.polyfit(case.warmth[known], value[known], 1)[0])
        place = case.place(in_table, name)
        if held(value[known], case.warmth[known]):
            what = "stays the same to the last digit while the screw warms or cools: a repeated value is no reading"
            yield Doubt(
                place, what, f"say by `fresh` what changes with a new one: {_itself(case, name)}, if nothing does"
            )
        if fit < -_CLEAR:
            what = f"falls by {-slope:.2g} um/K as the screw warms"
            yield Doubt(place, what, "turn its scale round: longer is positive")
        elif fit > _CLEAR and not 1 / _TIMES < slope / expected < _TIMES:
            what = f"grows by {slope:.2g} um/K, the span of {np.ptp(screw.span_mm):g} mm can by {expected:.2g}"
            yield Doubt(place, what, "correct its unit and scale, or the span")


def _itself(case: Case, name: str) -> str:
    """`fresh` as the reading's own signal or column."""
    rule = case.rig.channels.get(name) or case.rig.inputs[name]
    return f'fresh = "{case.of(name, rule)[0].source}"'


def _reading(case: Case, name: str) -> np.ndarray:
    """A reading in um, (ticks,): of the direct one what it reads at rest; NaN where there is none."""
    if name in case.rig.channels:
        return case.recording.channels[:, case.rig.index(name)]
    value = case.recording.inputs.get(name, np.full(len(case.recording), np.nan))
    return np.where(case.recording.omega > 0, np.nan, value)
