"""A run of the rig in software as another rig would send it: the signals that its rig.toml names, by its own DBC.

What a signal carries is found by the name of its channel or input; a thermometer reads what stands at its place.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from heapq import merge
from pathlib import Path
from typing import Any

import numpy as np

from drivers.canbus import can, cantools
from drivers.decode.dbc import find_dbc
from drivers.frames import Array
from drivers.virtual_rig import Run
from drivers.virtual_rig.frames.frames import EPOCH_S, GAP_S, drive_times
from drivers.virtual_rig.frames.recording import write_beside
from drivers.virtual_rig.machine.geometry import CHANNEL_MM
from estimator.errors import SetupError
from estimator.rig import RAD_S, Rig, Signal

NEAR_MM, DRIVE_HZ = 1.0, 50.0
NOT_MADE = ("scan_state", "scan_crc", "scan_number", "fault_mask", "checksums")  # of [log]
DRIVE = ("position", "speed", "current")
HELD = "displacement"  # sent when it is read; all else at each tick
AROUND = {
    "ambient": "ambient", "base": "base", "anchor_bracket": "bracket_anchor", "free_bracket": "bracket_free",
    "nut": "nut", "probe": "probe", "bar": "bar",
}  # fmt: skip

Column = tuple[Array, Array]  # times (n,) s and values (n,)


@dataclass
class Sent:
    """One message, or what one number of its multiplexer selects, at times (n,) s; values (n,) of its signals."""

    message: Any
    time_s: Array
    fixed: dict[str, float]
    values: dict[str, Array] = field(default_factory=dict)

    def messages(self, began_s: float) -> Iterator[can.Message]:
        """All of them in order."""
        about = {"arbitration_id": self.message.frame_id, "is_extended_id": self.message.is_extended_frame}
        for k, time_s in enumerate(self.time_s.tolist()):
            told = self.fixed | {name: float(column[k]) for name, column in self.values.items()}
            yield can.Message(began_s + time_s, data=self.message.encode(told, strict=False), **about)


class Encoded:
    """The frames of a run on the bus of a rig; of each tick the message that closes it comes last.

    closes_s      (K,) when each tick closes, s since the first frame
    thermometers  the channel of the simulated rig that each thermometer is
    """

    def __init__(self, run: Run, rig: Rig) -> None:
        self._run, self._rig = run, rig
        self.thermometers: dict[str, int] = {}
        if refused := [key for key in NOT_MADE if getattr(rig.log, key)]:
            raise self._error(f"log.{refused[0]}", "no frames are made with that; leave it out to simulate")
        dbc: Any = cantools.database.load_file(find_dbc(rig.log.dbc, rig.folder), strict=False)
        found: dict[tuple[str, int | None], Sent] = {}
        for name, signal in {**rig.channels, **rig.inputs}.items():
            time_s, values = self._column(name, signal)
            for path in signal.signals:
                self._put(found, dbc, path, time_s, (values - signal.offset) / signal.scale / len(signal.signals))
        self._sent = sorted(found.values(), key=lambda sent: sent.message.name == rig.log.closes)
        for k, sent in enumerate(self._sent):
            sent.time_s = sent.time_s + (k + 1) * GAP_S
        self._count()
        first_s = min(float(sent.time_s[0]) for sent in self._sent if len(sent.time_s))
        self.closes_s = run.measured.time_s + len(self._sent) * GAP_S - first_s

    def messages(self, began_s: float) -> Iterator[can.Message]:
        """In order of time."""
        return merge(*(sent.messages(began_s) for sent in self._sent), key=lambda message: message.timestamp)

    def write(self, path: Path, began_s: float = EPOCH_S) -> None:
        """Write a recording in the format of its suffix, with what was true beside it."""
        with can.Logger(path) as writer:
            for message in self.messages(began_s):
                writer.on_message_received(message)
        write_beside(self._run, path, self.closes_s, self.thermometers)

    def _column(self, name: str, signal: Signal) -> Column:
        """What a channel or input reads, in the rig's unit."""
        run, at_mm = self._run, getattr(signal, "at_mm", None)
        if at_mm is not None:
            k = int(np.argmin(np.abs(CHANNEL_MM - at_mm)))
            if abs(CHANNEL_MM[k] - at_mm) > NEAR_MM:
                places = ", ".join(f"{place:g}" for place in CHANNEL_MM)
                raise self._error(f"{name}: at_mm = {at_mm:g}", f"the simulated screw has its thermometers at {places}")
            self.thermometers[name] = k
            return run.measured.time_s, run.measured.channels[:, k]
        if name in DRIVE:
            drive = run.drive(np.unique(np.round(drive_times(run) * DRIVE_HZ)) / DRIVE_HZ)
            unit = RAD_S["rpm"] / RAD_S[signal.unit] if name == "speed" else 1.0
            columns = drive.position_mm, drive.speed_rpm * unit, drive.current_a
            return drive.time_s, columns[DRIVE.index(name)]
        if name == HELD:
            return run.holds.frozen_s, run.holds.reading.elongation_um
        ticks = {key: getattr(run.measured.environment, of) for key, of in AROUND.items()}
        ticks |= {"board": run.measured.board, "displacement_direct": run.measured.direct.elongation_um}
        if name not in ticks:
            raise self._error(name, f"the simulated rig has no such thing; it has {', '.join([*DRIVE, HELD, *ticks])}")
        return run.measured.time_s, ticks[name]

    def _put(self, found: dict[Any, Sent], dbc: Any, path: str, time_s: Array, values: Array) -> None:
        """One signal into its message."""
        message_name, _, name = path.partition(".")
        message = dbc.get_message_by_name(message_name)
        signal = message.get_signal_by_name(name)
        (selects,) = signal.multiplexer_ids or (None,)
        fixed = {s.name: 0.0 for s in message.signals if selects in (s.multiplexer_ids or [selects])}
        if selects is not None:
            fixed[signal.multiplexer_signal] = selects
        sent = found.setdefault((message_name, selects), Sent(message, time_s, fixed))
        if len(sent.time_s) != len(time_s):
            raise self._error(path, "one message with signals that come at different times; give each its own")
        sent.values[name] = values

    def _count(self) -> None:
        """The counters of the log, and what tells new readings by counting them: one more with each frame."""
        rules = {**self._rig.channels, **self._rig.inputs}.values()
        for path in {*self._rig.log.counters, *(rule.fresh for rule in rules if rule.fresh)}:
            message, _, name = path.partition(".")
            for sent in (each for each in self._sent if each.message.name == message and name not in each.values):
                sent.values[name] = np.arange(len(sent.time_s)) % 2 ** sent.message.get_signal_by_name(name).length

    def _error(self, what: str, why: str) -> SetupError:
        return SetupError(f"{self._rig.folder / 'rig.toml'}: {what}: {why}")
