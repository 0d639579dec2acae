"""The rig: geometry, material, channels and inputs; `rig_file.py` reads it from a rig folder.

Positions x are in mm from channel 1 (free end) to the motor side; fields carry their unit in their name.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from estimator.errors import SetupError, nearest
from estimator.rig_log import Log
from estimator.screw import Bed, Nut, Screw, Support

Vector = NDArray[Any]
AT_REST = 0.5  # rad/s, 5 rpm: a slower screw stands
RAD_S = {"rpm": 2 * np.pi / 60, "rad/s": 1.0}  # units that a speed may have
NOT_GEOMETRY = {"expansion_tolerance", "cells", "knots_mm"}
Part = TypeVar("Part")


@dataclass(frozen=True)
class Signal:
    """One measured value: where it comes from and what it may physically be.

    value = scale * (sum of the CAN signals, or the CSV column) + offset, in `unit`; outside lo..hi it counts as
    not measured. `fresh` names a CAN signal or CSV column that changes with each new reading (else each is one);
    `valid` is a condition such as "Message.Signal = 0".
    """

    signal: str | tuple[str, ...] = ()
    column: str | None = None
    unit: str = "degC"
    scale: float = 1.0
    offset: float = 0.0
    lo: float = -60.0
    hi: float = 200.0
    fresh: str | None = None
    valid: str | None = None

    @property
    def signals(self) -> tuple[str, ...]:
        """The CAN signals as "Message.Signal"."""
        return (self.signal,) if isinstance(self.signal, str) else tuple(self.signal)


@dataclass(frozen=True)
class Channel(Signal):
    """A signal that the filter compares with its model: a thermometer on the screw or in a body, or a length."""

    at_mm: float | None = None
    node: str | None = None

    @property
    def is_thermometer(self) -> bool:
        """Whether the channel reads a temperature (else: the displacement, in um)."""
        return self.at_mm is not None or self.node is not None


@dataclass(frozen=True)
class Rig:
    """A whole installation. `channels` keeps the order of the file; the displacement is a channel like the others.

    zero_C     temperature of the whole screw at which its growth is zero; None: growth counts from the first sample
    zero_sd_K  how well all thermometers together are known against it
    """

    name: str
    tick_s: float
    channels: Mapping[str, Channel]
    inputs: Mapping[str, Signal]
    screw: Screw | None = None
    nut: Nut | None = None
    bed: Bed | None = None
    supports: Mapping[str, Support] = field(default_factory=dict)
    log: Log = field(default_factory=Log)
    subset_7: tuple[str, ...] = ()
    zero_C: float | None = None
    zero_sd_K: float = 0.0
    folder: Path = Path()

    def __repr__(self) -> str:
        return f"Rig: {self.name}, {len(self.thermometers)} thermometers, a tick of {self.tick_s:g} s"

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Channel names in order, (m,)."""
        return tuple(self.channels)

    @property
    def expansion_tolerance(self) -> float:
        """How well the expansion coefficient is known, as a share of it; 0 without a screw."""
        return self.screw.expansion_tolerance if self.screw else 0.0

    @cached_property
    def thermometers(self) -> tuple[str, ...]:
        """Names of the channels that read a temperature, in order."""
        return tuple(name for name, channel in self.channels.items() if channel.is_thermometer)

    @cached_property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies that thermometers read."""
        return tuple(sorted({channel.node for channel in self.channels.values() if channel.node is not None}))

    @cached_property
    def is_thermometer(self) -> Vector:
        """Which channels read a temperature, (m,) bool."""
        return np.array([channel.is_thermometer for channel in self.channels.values()], dtype=bool)

    @cached_property
    def x_mm(self) -> Vector:
        """Where along the screw each channel reads, (m,) mm; NaN: nowhere there."""
        return np.array([np.nan if one.at_mm is None else one.at_mm for one in self.channels.values()], dtype=float)

    @cached_property
    def seats(self) -> Vector:
        """Share of each cell inside a bearing, (cells,); nothing without a screw."""
        screw = self.screw
        if screw is None:
            return np.zeros(0)
        ends = [(each.at_mm - each.width_mm / 2, each.at_mm + each.width_mm / 2) for each in self.supports.values()]
        return np.clip(sum((screw.overlap(*each) for each in ends), np.zeros(screw.cells)), 0.0, 1.0)

    @property
    def lengths(self) -> tuple[str, ...]:
        """Names of the channels that read a length, in order."""
        return tuple(name for name, channel in self.channels.items() if not channel.is_thermometer)

    @property
    def moves(self) -> bool:
        """Whether anything is told of a motion."""
        return bool({"speed", "position"} & {*self.inputs})

    @cached_property
    def stroke_mm(self) -> tuple[float, float] | None:
        """Table positions at which the nut is between the bearings; None where a table has no error by growth."""
        screw, nut, anchor = self.screw, self.nut, self.supports.get("anchor")
        if screw is None or nut is None or anchor is None or "position" not in self.inputs:
            return None
        others = [each.at_mm for each in self.supports.values() if each is not anchor] or [screw.from_mm, screw.to_mm]
        low, high = sorted((anchor.at_mm, max(others, key=lambda at_mm: abs(at_mm - anchor.at_mm))))
        centres = low + nut.length_mm / 2, high - nut.length_mm / 2
        lowest, highest = sorted((centre - nut.centre_mm) / nut.direction for centre in centres)
        return lowest, highest

    def index(self, name: str) -> int:
        """Column of a channel; an unknown name is a SetupError."""
        if name not in self.channels:
            raise SetupError(f"{self.folder / 'rig.toml'}: no channel '{name}'; {nearest(name, self.channels)}")
        return self.names.index(name)

    def the_screw(self) -> Screw:
        """The body along x, for an effect that needs one; without it a SetupError."""
        return self._the("screw", self.screw)

    def the_nut(self) -> Nut:
        """The nut, likewise."""
        return self._the("nut", self.nut)

    def the_support(self, name: str) -> Support:
        """A bearing by name, likewise."""
        return self._the(f"supports.{name}", self.supports.get(name))

    def _the(self, key: str, part: Part | None) -> Part:
        if part is None:
            raise SetupError(f"needs [{key}], which {self.name} has not; add it to rig.toml or leave the effect out")
        return part

    def fingerprint(self) -> str:
        """Short hash of geometry and material, kept in fitted models; not of the mesh or of how well they are known."""
        screw = self.screw and {k: v for k, v in asdict(self.screw).items() if k not in NOT_GEOMETRY}
        return hashlib.sha256(repr((screw, self.nut, sorted(self.supports.items()))).encode()).hexdigest()[:12]
