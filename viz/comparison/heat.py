"""Heat that one or two models alone lack along the screw, on the mean while driving and at rest, with its sd."""

from collections.abc import Sequence

import rerun.blueprint as rrb

from viz.comparison.compared import ComparedRun
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.frames import Axes
from viz.drawing.views import flat
from viz.figures import along
from viz.figures.along import Curve

VIEW = 660.0, 285.0  # points
LEAST_W_M = 1.0  # the frame holds at least so much
ALONG = "along"


def curves(run: ComparedRun) -> dict[str, list[Curve]]:
    """Of each side, by what the machine does; none on a rig without a screw."""
    does = dict.fromkeys(name for one in run.sides if len(one.along.places_mm) for name in one.along.W_m)
    return {
        name: [
            Curve(side, paths.COMPARED_AS[side], one.along.places_mm, one.along.W_m[name], one.along.sd_W_m[name])
            for side, one in run.named.items()
        ]
        for name in does
    }


def send(at: Entity, run: ComparedRun) -> None:
    """Log a figure for driving and one for rest."""
    for name, own in curves(run).items():
        along.send(at / ALONG / paths.root(name), frame_of(run, own), run.rig, own, run.travel_mm, "place x [mm]")


def views(run: ComparedRun, models: Sequence[str]) -> list[rrb.Spatial2DView]:
    """The views of both."""
    said = f": {', '.join(models)}" if len(models) == 1 else ""
    return [
        flat(
            paths.compared(paths.root(run.name), ALONG, name),
            f"Heat missing {name}{said} [W/m over mm]",
            frame_of(run, own).bounds,
        )
        for name, own in curves(run).items()
    ]


def frame_of(run: ComparedRun, own: Sequence[Curve]) -> Axes:
    """The frame of curves, in which noise does not fill the height."""
    screw = run.rig.the_screw()
    return along.axes_of((screw.from_mm, screw.to_mm), own, VIEW, LEAST_W_M)
