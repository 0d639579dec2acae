"""What the filter says: a Step for each tick, a Track for a whole recording; every channel alike."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np

from estimator.cover import LONG
from estimator.record import Array, Recording


class Mode(IntEnum):
    """What the estimate rests on; values as sent on the bus."""

    INIT = 0
    PREDICT = 1
    UPDATE = 2
    COASTING = 3
    INVALID = 14


@dataclass(frozen=True, slots=True)
class Step:
    """The estimate after one tick.

    time_s            s since the first frame
    elongation_um     growth of the measured span since the start, or since the rig's zero_C; sigma_um its standard
                      deviation
    open_loop_um      the same by the model alone
    profile_C         (x,) temperatures at the estimator's display places; profile_sd_K likewise
    bodies_C          (bodies,) temperatures of nut and housings
    error_at_table_um growth between the anchor bearing and the nut's centre; NaN where the position is not known
    measured, predicted, innovation, innovation_sd, fused, why   (m,) for each channel
    fault, since_s    (m,) what is wrong with each channel, a Fault, and since when
    may_drift_K       (m,) by how much a thermometer that is fused may have drifted, since since_s; 0: not suspected
    lacks_K           (m,) by how much heat that the model lacks sets a thermometer apart from the others; 0: none does
    unsure_um         of sigma_um, what comes of channels that may drift, and of such heat
    off_share         by which share of their values the model's parameters must be off, 0: they are what a fit says
    shift_mm          by how much the nut's heat stands elsewhere than the position says, 0: it does not
    jump              (m,) by how much its zero has become another one with this tick; 0 where it has not
    input_fault       (p,) why each input of the rig is held, a Fault, NONE: it is not
    begins            whether the run began with this tick; again, where what it had begun with were no temperatures
    open_loop         (m,) what the channels would read by the model alone
    nis, nis_channels e' S^-1 e over the fused channels, and how many they are
    position_mm       of the table, that the error there is for; a tick or two old where the drive was late
    """

    time_s: float
    mode: Mode
    elongation_um: float
    sigma_um: float
    open_loop_um: float
    profile_C: Array
    profile_sd_K: Array
    bodies_C: Array
    error_at_table_um: float
    error_at_table_sd_um: float
    names: tuple[str, ...]
    measured: Array
    predicted: Array
    innovation: Array
    innovation_sd: Array
    fused: Array
    fault: Array
    since_s: Array
    may_drift_K: Array
    lacks_K: Array
    unsure_um: float
    off_share: float
    shift_mm: float
    jump: Array
    input_fault: Array
    begins: bool
    why: tuple[str, ...]
    open_loop: Array
    nis: float
    nis_channels: int
    position_mm: float

    def __repr__(self) -> str:
        return f"{self.time_s:.0f} s, {self.mode.name}: {self.elongation_um:.2f} +- {self.sigma_um:.2f} um"


@dataclass(frozen=True)
class Track:
    """The steps of a whole recording: the fields of Step with a leading axis K.

    x_mm     (x,) places of the profile
    bodies   names of the bodies
    names    channel names (m,)
    """

    x_mm: Array
    bodies: tuple[str, ...]
    names: tuple[str, ...]
    time_s: Array
    mode: Array
    elongation_um: Array
    sigma_um: Array
    open_loop_um: Array
    profile_C: Array
    profile_sd_K: Array
    bodies_C: Array
    error_at_table_um: Array
    error_at_table_sd_um: Array
    measured: Array
    predicted: Array
    innovation: Array
    innovation_sd: Array
    fused: Array
    fault: Array
    since_s: Array
    may_drift_K: Array
    lacks_K: Array
    unsure_um: Array
    off_share: Array
    shift_mm: Array
    jump: Array
    input_fault: Array
    begins: Array
    open_loop: Array
    nis: Array
    nis_channels: Array
    position_mm: Array

    @classmethod
    def waiting(cls, names: tuple[str, ...], rows: Recording) -> "Track":
        """Ticks before any thermometer has been read: nothing to say but what was measured."""
        K, m = len(rows), len(names)
        said = {name: np.full(K, np.nan) for name in SERIES}
        said |= {name: np.full((K, m), np.nan) for name in LINES}
        said |= {name: np.empty((K, 0)) for name in (*PROFILES, "bodies_C")}
        said |= {"time_s": rows.time_s, "measured": rows.channels, "fused": np.zeros((K, m), dtype=bool)}
        said |= {"fault": np.zeros((K, m), dtype=np.int8), "begins": np.zeros(K, dtype=bool)}
        said |= {name: np.zeros((K, m)) for name in ("jump", "may_drift_K", "lacks_K")}
        said |= {"input_fault": np.zeros((K, len(rows.inputs)), dtype=np.int8)}
        said |= {"mode": np.full(K, Mode.INIT), "nis_channels": np.zeros(K, dtype=int)}
        said |= {name: np.zeros(K) for name in ("unsure_um", "off_share", "shift_mm")}
        return cls(np.empty(0), (), names, **said)

    @classmethod
    def of(cls, steps: Sequence[Step], x_mm: Array, bodies: tuple[str, ...]) -> "Track":
        """Steps one after the other."""
        series = {key: _stack([np.asarray(getattr(step, key)) for step in steps]) for key in SERIES}
        return cls(x_mm, bodies, steps[0].names, **series)

    @classmethod
    def joined(cls, parts: "Iterable[Track]", ticks: int) -> "Track":
        """Parts of one run of so many ticks, one after the other, each let go as the next comes, or a day would be in
        memory twice; of a long one profiles, half of all, have the seven digits of single precision. Ticks before the
        start have no places and no bodies, and are NaN there."""
        series, at = dict[str, Array](), 0
        x_mm, bodies, names = np.empty(0), tuple[str, ...](), tuple[str, ...]()
        for part in parts:
            for key in SERIES:
                rows = getattr(part, key)
                rows = rows.astype(np.float32) if ticks > LONG and key in PROFILES else rows
                series[key] = _room(series.get(key), rows, ticks, at)
                series[key][at : at + len(part)] = rows if rows.shape[1:] == series[key].shape[1:] else np.nan
            if len(part.x_mm) or part.bodies:
                x_mm, bodies = part.x_mm, part.bodies
            names, at = part.names, at + len(part)
        return cls(x_mm, bodies, names, **series)

    def step(self, k: int, why: tuple[str, ...]) -> Step:
        """Tick k, with the reasons for which channels were not fused."""
        row = {key: getattr(self, key)[k] for key in SERIES}
        said = {key: value if value.ndim else value.item() for key, value in row.items()}
        return Step(**(said | {"mode": Mode(said["mode"])}), names=self.names, why=why)

    def __len__(self) -> int:
        return len(self.time_s)


@dataclass(frozen=True)
class TableErrors:
    """Growth between the anchor bearing and the nut's centre over K ticks, were the table at each of p places: what a
    control would compensate there, wherever the table is.

    at_mm     (p,) table positions
    error_um  (K, p), NaN before the start and where the rig has no such thing;   sd_um (K, p)
    """

    at_mm: Array
    error_um: Array
    sd_um: Array

    @classmethod
    def waiting(cls, at_mm: Array, ticks: int) -> "TableErrors":
        """Ticks before any thermometer has been read."""
        return cls(at_mm, *np.full((2, ticks, len(at_mm)), np.nan))

    @classmethod
    def joined(cls, parts: "Sequence[TableErrors]") -> "TableErrors":
        """Parts of one run, one after the other."""
        return cls(
            parts[0].at_mm, *(np.concatenate([getattr(one, key) for one in parts]) for key in ("error_um", "sd_um"))
        )

    def at(self, at_mm: Sequence[float]) -> "TableErrors":
        """Some of the places."""
        columns = [int(np.argmin(np.abs(self.at_mm - one))) for one in at_mm]
        return TableErrors(self.at_mm[columns], self.error_um[:, columns], self.sd_um[:, columns])


PROFILES = ("profile_C", "profile_sd_K")
LINES = ("predicted", "innovation", "innovation_sd", "open_loop", "since_s")  # of channels, NaN before the start
SERIES = tuple(field.name for field in fields(Track) if field.name not in ("x_mm", "bodies", "names"))


def _room(whole: Array | None, rows: Array, ticks: int, at: int) -> Array:
    """An array for all ticks that takes rows like these, or narrower ones, with what it had before `at`."""
    kind = rows.dtype if whole is None else np.result_type(whole, rows)
    if whole is not None and whole.shape[1:] >= rows.shape[1:] and whole.dtype == kind:
        return whole
    room = np.empty((ticks, *rows.shape[1:]), kind)
    if whole is not None:
        room[:at] = whole[:at] if whole.shape[1:] == rows.shape[1:] else np.nan
    return room


def _stack(rows: list[Array]) -> Array:
    """Rows into an array; the empty ones of ticks before the start become NaN."""
    width = max(row.size for row in rows)
    return np.array([row if row.size == width else np.full(width, np.nan) for row in rows])
