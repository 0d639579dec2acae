"""Heat or cold at one place of the screw: an air jet, chips, a motor behind its coupling."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np

from estimator.effect import Effect, Param
from estimator.inputs.inputs import Inputs
from estimator.rig import Rig
from estimator.terms import SCREW, Heat, Term


def spot(rig: Rig, at_mm: Any, width_mm: Any) -> Any:
    """Share of a heat put in around a place that falls to each cell, (..., cells); sums to 1. Smooth in the place.

    exp(-(x - at)^2 / (2 s^2)), s = width / sqrt(12): as wide as an even spread over the width
    """
    share = np.exp(-6.0 * ((rig.the_screw().x_mm - at_mm) / width_mm) ** 2)
    return share / share.sum(axis=-1, keepdims=True)


class LocalHeat(Effect):
    """Something heats or cools the screw at one place, always.

    q = P around the place `at`
    """

    trace = "One place too warm or too cold from the first minute on, at rest and while driving."
    power = Param(1.5, "W", lo=-500.0, hi=500.0, null=0.0, source="a chip pile or an air jet, a few W")
    at = Param(400.0, "mm", lo=-500.0, hi=5000.0, over="place", source="by fit")
    width = Param(30.0, "mm", lo=5.0, hi=300.0, sd=12.0, source="a jet's footprint")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        yield Heat(SCREW, p.power, over=spot(rig, p.at, p.width))


class LocalHeatDriving(Effect):
    """Something heats or cools the screw at one place while it turns.

    q = P around the place `at` while the screw turns, else 0
    """

    trace = "One place too warm or too cold while driving, fading after every stop."
    power = Param(
        2.0, "W", lo=-500.0, hi=500.0, null=0.0, source="a rubbing seal or a jet that follows the drive, a few W"
    )
    at = Param(400.0, "mm", lo=-500.0, hi=5000.0, over="place", source="by fit")
    width = Param(30.0, "mm", lo=5.0, hi=300.0, sd=12.0, source="a seal's or a jet's footprint")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        yield Heat(SCREW, p.power * u.motion.turning, over=spot(rig, p.at, p.width))


class MotorHeat(Effect):
    """The motor warms the screw through its coupling while driving, whatever the speed.

    q = P into the last `width` of the screw on the anchor's side while the screw turns, else 0
    """

    trace = "The motor end alone is too cold; grows with how long a drive lasts and not with its speed."
    power = Param(15.0, "W", lo=0.0, hi=1000.0, null=0.0, source="losses of a servo motor, 10 - 100 W, part of them")
    width = Param(40.0, "mm", lo=5.0, hi=200.0, sd=15.0, source="length of a coupling hub's seat")

    def terms(self, p: SimpleNamespace, u: Inputs, rig: Rig) -> Iterator[Term]:
        screw, anchor = rig.the_screw(), rig.the_support("anchor").at_mm
        at_end = abs(screw.to_mm - anchor) < abs(anchor - screw.from_mm)
        end = screw.to_mm if at_end else screw.from_mm
        inwards = np.abs(screw.x_mm - end)
        share = 1.0 / (1.0 + np.exp((inwards - p.width) / 2.0))
        yield Heat(SCREW, p.power * u.motion.turning, over=share / share.sum(axis=-1, keepdims=True))
