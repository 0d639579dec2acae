"""Where the nut was, tick by tick, in a tenth of the memory: what is 0 is not kept, nor is what stays as it was."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import NDArray

Array = NDArray[Any]

LONG = 20_000  # ticks; a longer run is worked out some ticks at a time, a shorter one at once, and models share more
AT_ONCE = 4096  # so many, whose covers are 9 MB


class Cover(NDArrayOperatorsMixin):
    """Share of each tick in which the nut covers each cell of the screw, (K, cells), as an array that is not written.

    `np.asarray(cover)` has the numbers, all of them equal to those it was made of; a slice is a Cover, a row an array.
    Each is kept from its first cell that is not 0 to its last, and once for as many ticks as it stays the same.

    at      (K,) which row each tick has      first   (rows,) its first cell
    ends    (rows + 1,) where the values of each row end, those of the first begin at 0      values  of all rows
    """

    ndim = 2

    def __init__(self, at: Array, first: Array, ends: Array, values: Array, cells: int) -> None:
        self._at, self._first, self._ends, self._values = at, first, ends, values
        self.shape, self.dtype = (len(at), cells), values.dtype

    @classmethod
    def of(cls, numbers: Array) -> "Cover":
        """From numbers (K, cells); a tick that is not known is a row of NaN."""
        bits = np.ascontiguousarray(numbers).view(f"u{numbers.itemsize}")  # as numbers, no NaN is like another
        new = np.append(True, (bits[1:] != bits[:-1]).any(axis=1))[: len(numbers)]
        rows = numbers[new]
        used, cells = rows != 0, numbers.shape[1]
        used[~used.any(axis=1), :1] = True  # a nut that is beside the screw has a first cell too
        first = used.argmax(axis=1) if cells else np.zeros(len(rows), int)
        width = cells - used[:, ::-1].argmax(axis=1) - first if cells else first
        ends = np.append(0, np.cumsum(width))
        values = rows[_inside(first, width, cells)]
        return cls((np.cumsum(new) - 1).astype(np.int32), first.astype(np.int32), ends, values, cells)

    @classmethod
    def joined(cls, parts: "Sequence[Cover]") -> "Cover":
        """Some ticks behind others."""
        rows = np.cumsum([0, *(len(part._first) for part in parts)])
        values = np.cumsum([0, *(len(part._values) for part in parts)])
        return cls(
            np.concatenate([part._at + before for part, before in zip(parts, rows, strict=False)]).astype(np.int32),
            np.concatenate([part._first for part in parts]),
            np.append(0, np.concatenate([part._ends[1:] + k for part, k in zip(parts, values, strict=False)])),
            np.concatenate([part._values for part in parts]),
            parts[0].shape[1],
        )

    def __len__(self) -> int:
        return len(self._at)

    def __getitem__(self, which: Any) -> Any:
        if isinstance(which, (int, np.integer)):
            return np.asarray(self[[which]])[0]
        return Cover(self._at[which], self._first, self._ends, self._values, self.shape[1])

    def __iter__(self) -> Iterator[Array]:
        for k in range(0, len(self), AT_ONCE):
            yield from np.asarray(self[k : k + AT_ONCE])

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        low, high = (int(self._at.min()), int(self._at.max()) + 1) if len(self) else (0, 0)
        rows = np.zeros((high - low, self.shape[1]), self.dtype if dtype is None else dtype)
        ends = self._ends[low : high + 1]
        rows[_inside(self._first[low:high], np.diff(ends), self.shape[1])] = self._values[ends[0] : ends[-1]]
        return rows if high - low == len(self) and (np.diff(self._at) == 1).all() else rows[self._at - low]

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        numbers = [np.asarray(one) if isinstance(one, Cover) else one for one in inputs]
        return getattr(ufunc, method)(*numbers, **options)

    @property
    def known(self) -> Array:
        """In which ticks it is, (K,)."""
        first = np.append(self._values, 0.0)[self._ends[:-1]]  # of a rig without a screw, 0
        return np.asarray(~np.isnan(first)[self._at])

    @property
    def nbytes(self) -> int:
        """Of memory."""
        return sum(each.nbytes for each in (self._at, self._first, self._ends, self._values))


def _inside(first: Array, width: Array, cells: int) -> Array:
    """Which cells, (rows, cells), are among the `width` of a row from its `first` on."""
    cell, first = np.arange(cells), first[:, None]
    return (cell >= first) & (cell < first + width[:, None])
