"""Colours that stand in one view are apart for all eyes: 20 in CIEDE2000 at least, also without red or green cones."""

from collections.abc import Sequence
from functools import cache
from itertools import combinations, pairwise
from typing import Any

import numpy as np
import pytest

from viz.drawing import paths
from viz.drawing.paths import LANES
from viz.drawing.scale import coloured

APART = 20.0
EYES = None, "Deuteranomaly", "Protanomaly"  # the last two in full: one kind of cones is missing
VIEWS = {
    "elongation": (
        paths.FILTER, paths.SMOOTHED, paths.OPEN_LOOP, paths.POLYLINE, paths.REFERENCE, paths.READING, paths.DIAL
    ),
    "profile": (paths.FILTER, paths.MEASURED, paths.LEFT_OUT, paths.NUT, paths.BOUND, paths.REFERENCE),
    "two models": (paths.BEFORE, paths.AFTER, paths.REFERENCE, paths.READING),
    "heat along": (paths.BEFORE, paths.AFTER, paths.NUT, paths.BOUND),
    "heat of bodies": (paths.BEFORE, paths.AFTER, paths.CROSS_VALIDATED),
    "bars of errors": (paths.CROSS_VALIDATED, paths.HELD_OUT),
    "how sure": (paths.BAND_EDGE, paths.REFERENCE, paths.LEFT_OUT),
    "surprises": (paths.FILTER, paths.POLYLINE, paths.READING),
    "drive": [LANES[name] for name in ("driving", "at rest", "speed unknown")],
    "mode": [*(LANES[name] for name in ("init", "predict", "update", "coasting")), paths.LEFT_OUT],
    "estimate": (paths.VALID, LANES["no estimate yet"], paths.LEFT_OUT),
    "sent": [LANES[name] for name in ("sent", "sent as invalid", "not")],
    "channel": [LANES[name] for name in ("used", "suspect", "muted", "silent", "not read", "refused")],
}  # fmt: skip


@cache
def science() -> Any:
    """colour-science, late: it takes seconds."""
    with np.printoptions():  # it changes how numpy prints, for all tests after it
        import colour
    return colour


def lab(colours: Sequence[paths.Colour], eyes: str | None) -> np.ndarray:
    """Colours (n, 3) in CIE L*a*b* as these eyes see them."""
    colour = science()
    linear = colour.models.eotf_sRGB(np.array(colours) / 255.0)
    if eyes:
        linear = np.clip(linear @ colour.blindness.matrix_cvd_Machado2009(eyes, 1.0).T, 0.0, 1.0)
    return colour.XYZ_to_Lab(colour.RGB_to_XYZ(linear, "sRGB"))


def apart(pairs: Sequence[tuple[paths.Colour, paths.Colour]], eyes: str | None) -> float:
    """CIEDE2000 of the pair that is hardest to tell apart."""
    one, other = (lab(some, eyes) for some in zip(*pairs, strict=True))
    return float(np.min(science().delta_E(one, other, method="CIE 2000")))


@pytest.mark.parametrize("eyes", EYES)
@pytest.mark.parametrize("view", VIEWS)
def test_what_stands_in_one_view_is_told_apart(view: str, eyes: str | None) -> None:
    assert apart(list(combinations(VIEWS[view], 2)), eyes) >= APART


@pytest.mark.parametrize("eyes", EYES)
def test_runs_that_follow_each_other_are_told_apart(eyes: str | None) -> None:
    assert apart(list(pairwise(paths.RUNS)), eyes) >= APART


@pytest.mark.parametrize("eyes", EYES)
def test_what_is_warmer_is_lighter_and_so_are_thermometers_one_by_one(eyes: str | None) -> None:
    many, fifteen = (coloured(np.arange(n), (0.0, n - 1.0))[:, :3] for n in (64, 15))
    assert (np.diff(lab(many, eyes)[:, 0]) > 0.0).all()
    assert (np.diff(lab(fifteen, eyes)[:, 0]) > 1.0).all()
