"""The screw in space: coloured by temperature, its growth exaggerated, with nut and bearings.

Seen from the front: free end left, motor right. It is held at the anchor bearing, so it grows past the mark at the free
end. Units of the scene are mm.
"""

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike, NDArray

from estimator.record import Array
from estimator.rig import Rig
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.scale import BodyScale, coloured, step_of

RING = 10
BAR_WIDTH = 0.5  # of the screw
SHOWN_SHARE = 0.08  # the largest growth is drawn as about this share of the screw


def exaggeration(rig: Rig, scale: BodyScale) -> float:
    """How many times too large growth is drawn, a round number."""
    largest = max(abs(end) for end in scale.elongation_um)
    return step_of(SHOWN_SHARE * 1e3 * _length_mm(rig) / max(largest, 1.0), 1) / 2


def style(at: Entity, rig: Rig, places: int) -> None:
    """Log what does not move, once: the tube, bearings, the mark of the cold end, the colours of the colour bar."""
    at, screw = at / paths.SCREW, rig.the_screw()
    radius = screw.outer_mm / 2
    at.log(rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    vertices, normals, triangles = _tube(np.linspace(screw.from_mm, screw.to_mm, places), radius)
    (at / "tube").log(rr.Mesh3D(vertex_positions=vertices, vertex_normals=normals, triangle_indices=triangles))
    end, arm = screw.from_mm, 2.6 * radius
    cross = [[[end, -arm, 0], [end, arm, 0]], [[end, 0, -arm], [end, 0, arm]]]
    (at / "cold_end").log(rr.LineStrips3D(cross, radii=rr.Radius.ui_points(1), colors=paths.TEXT))
    for name, support in rig.supports.items():
        box = _box(support.width_mm, 1.9 * radius, paths.METAL, [[support.at_mm, 0, 0]])
        (at / "bearing" / paths.root(name)).log(box)
    if rig.nut is not None:
        (at / "nut").log(_box(rig.nut.length_mm, 1.6 * radius, paths.NUT))
    labels = {f"{name} bearing": (support.at_mm, 1.6 * arm) for name, support in rig.supports.items()}
    labels["end when cold"] = end, -1.3 * arm
    _words(at / "names", [[x, 0.0, z] for x, z in labels.values()], list(labels))
    _bar(at / "bar", rig)


def _box(
    length_mm: float, half_mm: float, colour: paths.Colour, centres: list[list[float]] | None = None
) -> rr.Boxes3D:
    sizes = [[length_mm / 2, half_mm, half_mm]]
    return rr.Boxes3D(
        centers=centres, half_sizes=sizes, fill_mode="transparentfillmajorwireframe", colors=colour
    )  # fmt: skip


def _words(at: Entity, places: ArrayLike, texts: list[str], since_s: float | None = None) -> None:
    at.log(rr.Points3D(places, labels=texts, show_labels=True, radii=0.0, colors=paths.TEXT), since_s)


def _bar(at: Entity, rig: Rig) -> None:
    """A colour bar below the screw, as a row of boxes."""
    pieces, length = 48, _length_mm(rig)
    centers = _along_bar(rig, (np.arange(pieces) + 0.5) / pieces)
    colours = coloured(np.linspace(0.0, 1.0, pieces), (0.0, 1.0))
    half = [[BAR_WIDTH * length / pieces / 2, 1.0, 0.009 * length]]
    at.log(rr.Boxes3D(centers=centers, half_sizes=half, fill_mode="solid", colors=colours))


def bar_labels(at: Entity, rig: Rig, scale: BodyScale, since_s: float | None = None) -> None:
    """Log what the colours mean; where that changes, from `since_s` on, also how many times too large growth is."""
    growth = [] if since_s is None else [f"growth × {exaggeration(rig, scale):g}"]
    labels = [*(f"{tick:g} °C" for tick in np.linspace(*scale.temperature_C, 3)), *growth]
    places = _along_bar(rig, np.array([0.0, 0.5, 1.0, 1.6][: len(labels)]))
    places[:, 2] -= 0.012 * _length_mm(rig)
    _words(at / paths.SCREW / "bar_labels", places, labels, since_s)


def _along_bar(rig: Rig, shares: Array) -> Array:
    """Places (n, 3) along the colour bar, from its left end (0) to its right one (1)."""
    length = _length_mm(rig)
    x = rig.the_screw().from_mm + length * (0.5 + BAR_WIDTH * (shares - 0.5))
    return np.stack([x, np.zeros(len(x)), np.full(len(x), -0.163 * length)], axis=-1)


def _length_mm(rig: Rig) -> float:
    return rig.the_screw().to_mm - rig.the_screw().from_mm


def _tube(x_mm: Array, radius: float) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.uint32]]:
    """Rings of RING vertices at x: vertices and normals (x * RING, 3), triangles."""
    angle = np.linspace(0, 2 * np.pi, RING, endpoint=False)
    around = np.stack([np.zeros(RING), np.cos(angle), np.sin(angle)], axis=-1)
    normals = np.tile(around, (len(x_mm), 1))
    vertices = radius * normals
    vertices[:, 0] = np.repeat(x_mm, RING)
    i, j = np.meshgrid(np.arange(len(x_mm) - 1), np.arange(RING), indexing="ij")
    a, b = i * RING + j, i * RING + (j + 1) % RING
    sides = np.stack([a, b, a + RING, b, b + RING, a + RING], axis=-1).reshape(-1, 3)
    return vertices.astype(np.float32), normals.astype(np.float32), sides.astype(np.uint32)


def send(at: Entity, rig: Rig, scale: BodyScale, time_s: Array, profile_C: Array, elongation_um: Array) -> None:
    """Log n moments: temperatures (n, x) as colours, elongation (n,) as a stretch from the anchor, else the far end."""
    n, (lo, hi) = len(time_s), rig.the_screw().span_mm
    colours = np.repeat(coloured(profile_C, scale.temperature_C), RING, axis=1).reshape(-1, 4)
    stretch, shift = np.ones((n, 3)), np.zeros((n, 3))
    stretch[:, 0] += exaggeration(rig, scale) * elongation_um * 1e-3 / (hi - lo)
    held_mm = rig.supports["anchor"].at_mm if "anchor" in rig.supports else rig.the_screw().to_mm
    shift[:, 0] = held_mm * (1 - stretch[:, 0])
    shades = rr.Mesh3D.columns(vertex_colors=colours).partition(np.full(n, colours.shape[0] // n))
    (at / paths.SCREW / "tube").rows(time_s, [*shades, *rr.Transform3D.columns(translation=shift, scale=stretch)])


def send_nut(at: Entity, rig: Rig, time_s: Array, position_mm: Array) -> None:
    """Log where the nut is (n,)."""
    places = np.zeros((len(time_s), 3))
    places[:, 0] = rig.the_nut().centre(position_mm)
    (at / paths.SCREW / "nut").rows(time_s, rr.Transform3D.columns(translation=places))
