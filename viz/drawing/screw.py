"""The screw in space: coloured by temperature, its growth exaggerated, with nut and bearings.

Seen from the front: free end left, motor right. It is held at the anchor bearing, so it grows past the mark at the free
end. Units of the scene are mm.
"""

from __future__ import annotations

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from estimator.record import Array
from estimator.rig import Rig
from viz.drawing import paths
from viz.drawing.scale import BodyScale, coloured, step_of

RING = 10
BAR_WIDTH = 0.5  # of the screw
SHOWN_SHARE = 0.08  # the largest growth is drawn as about this share of the screw


def exaggeration(rig: Rig, scale: BodyScale) -> float:
    """How many times too large growth is drawn, a round number."""
    assert rig.screw is not None
    largest = max(abs(end) for end in scale.elongation_um)
    return step_of(SHOWN_SHARE * 1e3 * (rig.screw.to_mm - rig.screw.from_mm) / max(largest, 1.0), 1) / 2


def held_mm(rig: Rig) -> float:
    """Where the screw is held: the anchor bearing, else its far end."""
    assert rig.screw is not None
    return rig.supports["anchor"].at_mm if "anchor" in rig.supports else rig.screw.to_mm


def style(rec: rr.RecordingStream, root: str, rig: Rig, x_mm: Array) -> None:
    """Log what does not move, once: the tube, bearings, the mark of the cold end, the colours of the colour bar."""
    assert rig.screw is not None
    at, radius = f"{root}/{paths.SCREW}", rig.screw.outer_mm / 2
    rec.log(at, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    vertices, normals, triangles = _tube(x_mm, radius)
    tube = rr.Mesh3D(vertex_positions=vertices, vertex_normals=normals, triangle_indices=triangles)
    rec.log(f"{at}/tube", tube, static=True)
    end, arm = rig.screw.from_mm, 2.6 * radius
    cross = [[[end, -arm, 0], [end, arm, 0]], [[end, 0, -arm], [end, 0, arm]]]
    rec.log(f"{at}/cold_end", rr.LineStrips3D(cross, radii=rr.Radius.ui_points(1), colors=paths.TEXT), static=True)
    for name, support in rig.supports.items():
        half = [[support.width_mm / 2, 1.9 * radius, 1.9 * radius]]
        box = rr.Boxes3D(
            centers=[[support.at_mm, 0, 0]],
            half_sizes=half,
            fill_mode="transparentfillmajorwireframe",
            colors=paths.METAL,
        )
        rec.log(f"{at}/bearing/{paths.root(name)}", box, static=True)
    if rig.nut is not None:
        half = [[rig.nut.length_mm / 2, 1.6 * radius, 1.6 * radius]]
        box = rr.Boxes3D(half_sizes=half, fill_mode="transparentfillmajorwireframe", colors=paths.NUT)
        rec.log(f"{at}/nut", box, static=True)
    _names(rec, at, rig, arm)
    _bar(rec, at, rig)


def _names(rec: rr.RecordingStream, at: str, rig: Rig, arm: float) -> None:
    assert rig.screw is not None
    labels = {f"{name} bearing": support.at_mm for name, support in rig.supports.items()}
    labels["end when cold"] = rig.screw.from_mm
    heights = [-1.3 * arm if name == "end when cold" else 1.6 * arm for name in labels]
    places = [[x, 0.0, z] for x, z in zip(labels.values(), heights, strict=True)]
    words = rr.Points3D(places, labels=list(labels), show_labels=True, radii=0.0, colors=paths.TEXT)
    rec.log(f"{at}/names", words, static=True)


def _bar(rec: rr.RecordingStream, at: str, rig: Rig) -> None:
    """A colour bar below the screw, as a row of boxes."""
    pieces = 48
    centers = _along_bar(rig, (np.arange(pieces) + 0.5) / pieces)
    colours = coloured(np.linspace(0.0, 1.0, pieces), (0.0, 1.0))
    length = _length_mm(rig)
    half = [[BAR_WIDTH * length / pieces / 2, 1.0, 0.009 * length]]
    rec.log(f"{at}/bar", rr.Boxes3D(centers=centers, half_sizes=half, fill_mode="solid", colors=colours), static=True)


def bar_labels(rec: rr.RecordingStream, root: str, rig: Rig, scale: BodyScale, growth: bool = False) -> None:
    """Log what the colours mean, once; with `growth` also how many times too large it is drawn, from now on."""
    places = _along_bar(rig, np.array([0.0, 0.5, 1.0, 1.6][: 4 if growth else 3]))
    places[:, 2] -= 0.012 * _length_mm(rig)
    labels = [f"{tick:g} °C" for tick in np.linspace(*scale.temperature_C, 3)]
    labels += [f"growth × {exaggeration(rig, scale):g}"] if growth else []
    words = rr.Points3D(places, labels=labels, show_labels=True, radii=0.0, colors=paths.TEXT)
    rec.log(f"{root}/{paths.SCREW}/bar_labels", words, static=not growth)


def _along_bar(rig: Rig, shares: Array) -> Array:
    """Places (n, 3) along the colour bar, from its left end (0) to its right one (1)."""
    assert rig.screw is not None
    length = _length_mm(rig)
    x = rig.screw.from_mm + length * (0.5 + BAR_WIDTH * (shares - 0.5))
    return np.stack([x, np.zeros(len(x)), np.full(len(x), -0.163 * length)], axis=-1)


def _length_mm(rig: Rig) -> float:
    assert rig.screw is not None
    return rig.screw.to_mm - rig.screw.from_mm


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


def send(
    rec: rr.RecordingStream,
    root: str,
    rig: Rig,
    scale: BodyScale,
    time_s: Array,
    profile_C: Array,
    elongation_um: Array,
) -> None:
    """Log n moments: temperatures (n, x) as colours, elongation (n,) as a stretch away from the anchor."""
    assert rig.screw is not None
    n, (lo, hi) = len(time_s), rig.screw.span_mm
    colours = np.repeat(coloured(profile_C, scale.temperature_C), RING, axis=1).reshape(-1, 4)
    stretch, shift = np.ones((n, 3)), np.zeros((n, 3))
    stretch[:, 0] += exaggeration(rig, scale) * elongation_um * 1e-3 / (hi - lo)
    shift[:, 0] = held_mm(rig) * (1 - stretch[:, 0])
    columns = [
        *rr.Mesh3D.columns(vertex_colors=colours).partition(np.full(n, colours.shape[0] // n)),
        *rr.Transform3D.columns(translation=shift, scale=stretch),
    ]
    rec.send_columns(
        f"{root}/{paths.SCREW}/tube", indexes=[rr.TimeColumn(paths.TIMELINE, duration=time_s)], columns=columns
    )


def send_nut(rec: rr.RecordingStream, root: str, rig: Rig, time_s: Array, position_mm: Array) -> None:
    """Log where the nut is (n,)."""
    assert rig.nut is not None
    places = np.zeros((len(time_s), 3))
    places[:, 0] = rig.nut.centre(position_mm)
    index = [rr.TimeColumn(paths.TIMELINE, duration=time_s)]
    rec.send_columns(f"{root}/{paths.SCREW}/nut", indexes=index, columns=rr.Transform3D.columns(translation=places))
