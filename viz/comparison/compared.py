"""What is compared: two sides, each what one model says of a recording."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from estimator.record import Array
from estimator.rig import Rig
from viz.drawing import paths
from viz.drawing.scale import Range


@dataclass(frozen=True)
class HeatMap:
    """Heat that would repair a model alone, or that some of its effects bring, meaned over n stretches: a drive, the
    ten minutes after it and a rest are one each, however long the rest, a longer drive one for each ten minutes.

    time_s   (n,) begins;  phases  (n,) of str;  places_mm  (x,) on the screw;  W_m  (n, x)
    bodies   names of what is not a place;  W  (n, bodies)
    """

    time_s: Array
    phases: Sequence[str]
    places_mm: Array
    W_m: Array
    bodies: Sequence[str]
    W: Array


@dataclass(frozen=True)
class HeatAlong:
    """Heat that would repair a model alone over the screw, on the mean over a recording's drives, or its rests.

    places_mm  (x,);  W_m, sd_W_m  (x,) each, by what the machine does: "driving", "at rest"
    """

    places_mm: Array
    W_m: Mapping[str, Array]
    sd_W_m: Mapping[str, Array]


@dataclass(frozen=True)
class Side:
    """One model on one recording of K ticks.

    open_loop, predicted, innovation   (K, m) what channels read by the model alone, and a tick ahead by the filter
    elongation_um, sigma_um, open_loop_um  (K,) by the filter, with its sd, and by the model alone
    readings_um  (K,) of the displacement, joined by what the model leaves of them, NaN where there is none
    misfit   reading minus the model alone at times of its own, (n,) and (n, m); a zero without meaning taken out
    brought  heat that the effects bring that the other model has not
    """

    open_loop: Array
    predicted: Array
    innovation: Array
    elongation_um: Array
    sigma_um: Array
    open_loop_um: Array
    readings_um: Array
    misfit_time_s: Array
    misfit: Array
    heat: HeatMap
    along: HeatAlong
    brought: HeatMap | None = None


@dataclass(frozen=True)
class ComparedRun:
    """One recording of K ticks under one model, or two: before and after.

    name         shown as the title of its tab
    measured     (K, m)
    travel_mm    where the nut's ends have been; None where that is not known
    added        effects of the model after that the one before has not
    """

    name: str
    rig: Rig
    time_s: Array
    measured: Array
    sides: tuple[Side, ...]
    travel_mm: Range | None = None
    added: tuple[str, ...] = ()

    @property
    def named(self) -> dict[str, Side]:
        """The sides by "before" and "after"."""
        return dict(zip(paths.SIDES, self.sides, strict=False))

    @property
    def readings_um(self) -> Array:
        """(K,) as the last of the models joins them."""
        return self.sides[-1].readings_um

    def said(self, side: str) -> str:
        """How a legend begins: nothing to tell apart where there is one model."""
        return f"{side}, " if len(self.sides) > 1 else ""
