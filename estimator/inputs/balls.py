"""Which cells the balls of the nut cover, which carry on a part of it, from those that all of the nut covers.

Recordings keep the cover by the whole nut, a mean over where it was. For places of its centre, one a row, let the rows
of B be the cover by all of it, those of W by the balls, as much in sum. A cover c that is a mix of rows of B is, by the
balls,

    c + c B^+ (W - B)
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from estimator.cover import Cover
from estimator.record import Array
from estimator.rig import Rig
from estimator.screw import Nut, Screw

SURE = 1e-6  # of the largest singular value of B: a smaller one is rounding


@dataclass(frozen=True)
class Balls:
    """Where balls carry: on `width` of the nut's length, around a place `shift` mm from its middle, less the `gap`, a
    share of that, in the middle; 1 + `lean` times as much above that as they would if they carried alike, 1 - `lean`
    times below.
    """

    shift: Any
    width: Any
    gap: Any
    lean: Any = 0.0


class ByBalls:
    """A cover (ticks, cells) by the balls, worked out where it is asked for."""

    def __init__(self, cover: Array | Cover, rig: Rig, balls: Balls) -> None:
        self.cover, self._rig, self.balls = cover, rig, balls

    @property
    def is_complex(self) -> bool:
        """Whether where the balls carry is, or where the nut was."""
        return np.iscomplexobj(self.cover) or any(isinstance(value, complex) for value in vars(self.balls).values())

    def carried(self, q: Array, rows: Array) -> Array:
        """What is carried, q (ticks or 1, 1), on states that say `rows` (cells, n) of the cells: (ticks, n). At rest,
        and that is most of many recordings, it is nothing, wherever the nut is."""
        if len(q) != len(self.cover):
            return np.asarray(q * self._onto(slice(None), rows))
        at = np.flatnonzero(q)
        carried = np.zeros((len(q), rows.shape[1]), np.result_type(q, self.cover, self._moves))
        if len(at):
            carried[at] = q[at] * self._onto(at, rows)
        return carried

    def _onto(self, at: Array | slice, rows: Array) -> Array:
        """The cover at some ticks, projected, with the lesser of both products first."""
        cover = self.cover[at]
        if len(cover) < rows.shape[1]:
            return product(product(cover, self._moves), rows)
        return product(cover, product(self._moves, rows))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        """Cell by cell."""
        return np.asarray(self.cover @ self._moves, dtype)

    @property
    def _moves(self) -> Array:
        return _moves(self._rig.the_screw(), self._rig.the_nut(), self.balls)


@lru_cache(maxsize=16)
def _moves(screw: Screw, nut: Nut, balls: Balls) -> Array:
    """1 + B^+ (W - B), (cells, cells)."""
    at_mm, whole, inverse = _whole(screw, nut)
    middle, half = at_mm + balls.shift, nut.length_mm / 2 * balls.width
    to = [screw.overlap(screw.from_mm, middle + share * half) for share in (-1.0, -balls.gap, balls.gap, 1.0)]
    carry = (1.0 - balls.lean) * (to[1] - to[0]) + (1.0 + balls.lean) * (to[3] - to[2])
    some = carry.sum(axis=1, keepdims=True)
    more = carry * nut.length_mm / 1e3 / screw.length / np.where(some.real > 0.0, some, 1.0) - whole
    return np.asarray(np.eye(screw.cells) + product(inverse, more))


@lru_cache(maxsize=4)
def _whole(screw: Screw, nut: Nut) -> tuple[Array, Array, Array]:
    """Places of the nut's centre on the screw, half a cell apart (places,) mm, B (places, cells), and B^+."""
    half_mm = nut.length_mm / 2
    pitch_mm = screw.length * 500.0
    places = np.arange(screw.from_mm + half_mm + 0.3 * pitch_mm, screw.to_mm - half_mm, pitch_mm)  # off cells' borders
    cover = screw.overlap(places - half_mm, places + half_mm)
    return places, cover, np.linalg.pinv(cover, rcond=SURE)


def product(a: Array, b: Array) -> Array:
    """The product of two matrices, of which one may be complex: as one with the other's zero parts it takes four times
    as long, and parts that do not lie in one piece take twenty times. Of few rows both parts are read off one product,
    which reads the other matrix once."""
    if np.iscomplexobj(a) == np.iscomplexobj(b):
        return np.asarray(a @ b)
    if np.iscomplexobj(a):
        real, imag = np.split(np.concatenate([a.real, a.imag]) @ np.asarray(b), 2)
    else:
        real, imag = (np.asarray(a) @ np.ascontiguousarray(part) for part in (b.real, b.imag))
    return np.asarray(real + 1j * imag)
