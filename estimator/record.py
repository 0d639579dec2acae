"""What was measured: a Sample is one tick, a Recording all ticks. NaN = not measured."""

import hashlib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import repeat
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimator.cover import AT_ONCE, Cover

POWER_ON_C = (85.0, 0.0)  # what thermometers say that have not converted yet
Array = NDArray[Any]  # float64, or whole numbers where it holds indices
_COVERS = ("coverage", "stay")
_SERIES = ("time_s", "channels", "ages_s", "omega", "unevenness", "apart_s", "pace", "slip_mm", "idle")


@dataclass(frozen=True, slots=True)
class Sample:
    """One tick of a rig.

    time_s    s since the first frame, when the tick closed
    channels  (m,) in the order of Rig.names: degC, displacement um
    ages_s    (m,) s between a channel's reading and the close of the tick; 0 where it closes with it
    inputs    value of each input of the rig, in the rig file's unit: the last one of the tick
    omega     rad/s, mean of |speed| over the tick
    coverage  (cells,) share of the tick in which the nut covers each cell of the screw; while the screw turns, of the
              angle turned in the tick: where friction heats
    unevenness  mean of speed^2 over the square of the mean speed, 1: even. Friction that is not proportional to speed
              makes another heat in short strokes, whose ends count more
    idle      share of the tick in which the screw stands, though it turns before or after: what grows less than in
              proportion to speed is less by it
    apart_s  longest time from one reading of the speed to the next, of those that ended in the tick, s; 0: short beside
             a tick, inf: too long to know what was between, NaN: none was read
    pace     how far the position moved as a share of what the speed says, below 0: against it; inf: it moved though
             the speed was 0; NaN: it did not turn, or was not read
    slip_mm   by how much the position jumped from one frame to the next, 0: not; NaN: frames are too few to tell
    stay      (cells,) the coverage by time alone, waits at the ends of strokes included: where the nut conducts and
              keeps the air off; None: the same
    """

    time_s: float
    channels: Array
    ages_s: Array
    inputs: Mapping[str, float]
    omega: float
    coverage: Array
    unevenness: float = 1.0
    apart_s: float = 0.0
    pace: float = math.nan
    slip_mm: float = math.nan
    stay: Array | None = None
    idle: float = 0.0


@dataclass(frozen=True)
class Recording:
    """All ticks of one run, K rows one nominal tick apart; a tick that never came is a row of NaN.

    Fields as in Sample with a leading axis K; `coverage` and `stay` of what was read are a Cover each. `skipped`
    counts what was not used, by reason; `notes` are sentences about torn ends, clock jumps and the like, with place,
    `doubts` those of them that change how figures are read.
    `began_s`: when time_s is 0, s since 1970; None where the log's clock tells no date. `part_of`: fingerprint of the
    recording that these ticks are a stretch of, "": of none.
    """

    name: str
    time_s: Array
    channels: Array
    ages_s: Array
    inputs: Mapping[str, Array]
    omega: Array
    coverage: Array | Cover
    frames: int = 0
    skipped: Mapping[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    unevenness: Array = field(default_factory=lambda: np.ones(1))
    apart_s: Array = field(default_factory=lambda: np.zeros(1))
    pace: Array = field(default_factory=lambda: np.full(1, np.nan))
    slip_mm: Array = field(default_factory=lambda: np.full(1, np.nan))
    stay: Array | Cover = field(default_factory=lambda: np.empty(0))
    idle: Array = field(default_factory=lambda: np.zeros(1))
    began_s: float | None = None
    part_of: str = ""

    def __post_init__(self) -> None:
        usual = {"unevenness": 1.0, "idle": 0.0, "apart_s": 0.0, "pace": math.nan, "slip_mm": math.nan}
        for name, usually in usual.items():
            if len(getattr(self, name)) != len(self.time_s):
                object.__setattr__(self, name, np.full(len(self.time_s), usually))
        if self.stay.shape != self.coverage.shape:
            object.__setattr__(self, "stay", self.coverage)

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        channels = f"{self.channels.shape[-1]} channels, inputs {', '.join(self.inputs)}"
        return "\n".join([f"{self.name}: {len(self)} ticks, {self.time_s[-1] / 60:.1f} min, {channels}", *self.notes])

    @cached_property
    def fingerprint(self) -> str:
        """Short hash of what was measured: tells a recording again whatever its file is called, and by a part of it."""
        return self.part_of or hashlib.sha256(self.channels.tobytes() + self.time_s.tobytes()).hexdigest()[:12]

    def rows(self, which: slice) -> "Recording":
        """Some of the ticks, in order."""
        inputs = {name: column[which] for name, column in self.inputs.items()}
        return replace(self, inputs=inputs, **{key: getattr(self, key)[which] for key in (*_SERIES, *_COVERS)})

    def packed(self) -> "Recording":
        """The same, and where the nut was in a tenth of the memory."""
        return replace(self, coverage=Cover.of(np.asarray(self.coverage)), stay=Cover.of(np.asarray(self.stay)))

    @classmethod
    def joined(cls, parts: "Sequence[Recording]") -> "Recording":
        """Packed parts, one behind the other; name and account are those of the first."""
        series: dict[str, Any] = {key: np.concatenate([getattr(part, key) for part in parts]) for key in _SERIES}
        series |= {key: Cover.joined([getattr(part, key) for part in parts]) for key in _COVERS}
        inputs = {name: np.concatenate([part.inputs[name] for part in parts]) for name in parts[0].inputs}
        return replace(parts[0], inputs=inputs, **series)

    def sample(self, k: int) -> Sample:
        """Tick k."""
        return next(iter(self.rows(slice(k, k + 1))))

    def __iter__(self) -> Iterator[Sample]:
        """Tick after tick, numbers as Python has them: one by one an array hands them out ten times as slowly."""
        series = self.time_s, self.omega, self.unevenness, self.apart_s, self.pace, self.slip_mm, self.idle
        for at in (slice(k, k + AT_ONCE) for k in range(0, len(self), AT_ONCE)):
            names, columns = [*self.inputs], [column[at].tolist() for column in self.inputs.values()]
            values = zip(*columns, strict=True) if columns else repeat(())
            for channels, ages_s, coverage, stay, inputs, (time_s, omega, *rest, idle) in zip(
                self.channels[at], self.ages_s[at], self.coverage[at], self.stay[at], values,
                zip(*(each[at].tolist() for each in series), strict=True),
            ):  # fmt: skip
                inputs = dict(zip(names, inputs, strict=True))
                yield Sample(time_s, channels, ages_s, inputs, omega, coverage, *(*rest, stay, idle))


def collect(name: str, samples: Iterable[Sample], **about: object) -> Recording:
    """Stack samples into a Recording; `about` fills frames, skipped and notes."""
    rows = list(samples)
    if not rows:
        raise ValueError("a recording needs at least one sample")
    return Recording(
        name=name,
        time_s=np.array([s.time_s for s in rows]),
        channels=np.array([s.channels for s in rows]),
        ages_s=np.array([s.ages_s for s in rows]),
        inputs={key: np.array([s.inputs[key] for s in rows]) for key in rows[0].inputs},
        omega=np.array([s.omega for s in rows]),
        coverage=np.array([s.coverage for s in rows]),
        unevenness=np.array([s.unevenness for s in rows]),
        apart_s=np.array([s.apart_s for s in rows]),
        pace=np.array([s.pace for s in rows]),
        slip_mm=np.array([s.slip_mm for s in rows]),
        stay=np.array([s.coverage if s.stay is None else s.stay for s in rows]),
        idle=np.array([s.idle for s in rows]),
        **about,  # type: ignore[arg-type]
    )


def held(rows: Array, before: Array) -> Array:
    """The value `before` (m,) and those of rows (K, m), each gap filled by the one before it, (K + 1, m)."""
    rows = np.vstack([before, rows])
    at = np.maximum.accumulate(np.where(np.isfinite(rows), np.arange(len(rows))[:, None], 0), axis=0)
    return np.take_along_axis(rows, at, axis=0)
