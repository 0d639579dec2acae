"""Frames into ticks, as the rig file and its DBC say: one decoder for whole logs and for a tick of a live bus."""

from functools import cached_property
from itertools import chain

import numpy as np

from drivers.decode.checks import frame_checksum, lost
from drivers.decode.condense import Condenser, Readings, portions
from drivers.decode.dbc import Bits, Layout, find_dbc, load_dbc
from drivers.decode.scan import Scan
from drivers.decode.sources import Source, sources
from drivers.frames import Array, Frames, Index, Mask, Tally, Whole, few, id_of, words_of
from drivers.units import contradicts, unit_of
from estimator.record import Recording
from estimator.rig import Rig

_QUIET_TICKS = 2  # a message sent each tick has come by then


class Decoder:
    """What a rig makes of CAN frames. Carries counters, held values and the drive's last position from call to call."""

    def __init__(self, rig: Rig, tally: Tally) -> None:
        self.rig = rig
        self.tally = tally
        self.dbc = load_dbc(find_dbc(rig.log.dbc, rig.folder))
        self.scan = Scan(rig, self.dbc)
        self.sources: dict[str, list[Source]] = {}
        for source in sources(rig, self.dbc):
            self.sources.setdefault(source.message.name, []).append(source)
        key = f"{rig.folder / 'rig.toml'}: log"
        self.checksums = {self.dbc.signal(name, f"{key}.checksums")[0].name for name in rig.log.checksums}
        counters = [self.dbc.signal(name, f"{key}.counters") for name in rig.log.counters]
        self.counters: dict[str, Bits] = {message.name: bits for message, bits in counters}
        self.condenser = Condenser(rig, tally)
        self._counted: dict[str, int] = {}
        used = {*self.sources, *(m.name for m in self.scan.messages), *self.checksums, *self.counters}
        for message in self.dbc.messages.values():
            if message.broken:
                tally.note(f"{self.dbc.path.name}: message '{message.name}' is not read: {message.broken}")
        for name, why in self.dbc.left_out.items():
            tally.note(f"{self.dbc.path.name}: '{name}' is not read: {why}")
        for (said, unit), names in self._in_other_units().items():
            what = f"in {said} by {self.dbc.path.name}, in {unit} by rig.toml"
            tally.doubt(f"{few(names, 3)}: {what}: convert there, scale and offset")
        self.used = [m for m in self.dbc.messages.values() if m.name in used or m == self.scan.closing]

    def _in_other_units(self) -> dict[tuple[str, str], list[str]]:
        """Channels and inputs of which the DBC says another unit than a rig file that does not convert, by both."""
        found: dict[tuple[str, str], list[str]] = {}
        for source in chain.from_iterable(self.sources.values()):
            rule, unit = source.rule, source.parts[0].unit
            plain = (rule.scale, rule.offset) in ((1.0, 0.0), (1.0 / len(source.parts), 0.0))
            if plain and contradicts(unit_of(unit) or "", rule.unit):
                found.setdefault((unit, rule.unit), []).append(source.name)
        return found

    @cached_property
    def own(self) -> frozenset[tuple[int, bool]]:
        """Id and kind of the messages that we send: what of them comes back says nothing of the rig."""
        return frozenset((message.id, message.extended) for message in self.dbc.messages.values() if message.own)

    def not_ours(self, frames: Frames) -> Index:
        """Indices of the frames that we did not send ourselves."""
        ours = np.isin(frames.key, [message.key for message in self.dbc.messages.values() if message.own])
        self.tally.skip("sent by us", np.count_nonzero(ours))
        return np.flatnonzero(~ours)

    @cached_property
    def wanted(self) -> dict[int, str]:
        """Names of the messages that the rig needs, by key."""
        return {message.key: message.name for message in self.used}

    def never_came(self, frames: Frames) -> None:
        """Say first which messages of the rig are not there, or never whole, and what is not measured for that."""
        there = set(np.unique(frames.key).tolist())
        for message in self.used:
            sizes = np.unique(frames.dlc[frames.key == message.key]) if message.key in there else np.empty(0)
            if message.length in sizes:
                continue
            why = f"has {sizes[-1]} bytes, {message.length} in {self.dbc.path.name}" if len(sizes) else "never came"
            if message.key ^ 1 in there:
                bits = 29 if message.extended else 11
                why += f", but {id_of(message.key ^ 1)} did: {self.dbc.path.name} has it with {bits} bits"
            lost = ", ".join(source.name for source in self.sources.get(message.name, ()))
            self.tally.doubt(f"{message.name} (0x{message.id:X}) {why}{f': no {lost}' if lost else ''}")

    def closings(self, frames: Frames) -> tuple[Mask, Whole]:
        """Which frames close a scan, (n,), and their scan number, (n,), -1 where there is none."""
        number = np.full(len(frames), -1, np.int64)
        closing = self.scan.closing
        if closing is None:
            return np.zeros(len(frames), bool), number
        which = (frames.key == closing.key) & (frames.dlc == closing.length)
        number[which] = self.scan.numbers(words_of(frames.data[which]))
        return which, number

    def closing(self, can_id: int, extended: bool, data: bytes) -> int | None:
        """The same for one frame: its scan number, -1 where there is none; None if it closes nothing."""
        closing = self.scan.closing
        if closing is None or (can_id, extended, len(data)) != (closing.id, closing.extended, closing.length):
            return None
        return int(self.scan.numbers(words_of(np.frombuffer(data.ljust(8, b"\0"), np.uint8)[None]))[0])

    def rows(self, frames: Frames, first: int, now: Array, row: Index, date: Array) -> Recording:
        """Condense frames into ticks.

        frames  (n,) in order; the first has number `first` in the log     now   (n,) s on the rig's clock
        row     (n,) tick of each, 0 ... K - 1, rising                     date  (K,) s, when each tick closed
        """
        self._account(frames)
        rows = len(date)
        readings: dict[str, Readings] = {}
        last: dict[str, Index] = {}
        for message in self.used:
            index = self._frames_of(message, frames)
            words = words_of(frames.data[index])
            last[message.name] = np.full(rows, -1, np.intp)
            last[message.name][row[index]] = index
            for source in self.sources.get(message.name, ()):
                use, value = source.read(words, now[index], _QUIET_TICKS * self.rig.tick_s, self.tally)
                at = index[use]
                readings[source.name] = Readings(first + at, row[at], now[at], value[use])
        self._check_scans(readings, frames, last, rows)
        return self.condenser.rows(readings, date)

    def whole(self, frames: Frames, now: Array, row: Index, date: Array) -> Recording:
        """The same of a whole log, some ticks at a time, or what is made of its frames would fill the memory."""
        parts = []
        for ticks in portions(len(date)):
            at = slice(*np.searchsorted(row, [ticks.start, ticks.stop]))
            parts.append(self.rows(frames.take(at), at.start, now[at], row[at] - ticks.start, date[ticks]).packed())
        return Recording.joined(parts)

    def _check_scans(self, readings: dict[str, Readings], frames: Frames, last: dict[str, Index], rows: int) -> None:
        bad, sound = self.scan.bad(frames, last, rows, self.tally), np.zeros(rows, bool)
        for source in chain.from_iterable(self.sources.values()):
            signals = (f"{source.message.name}.{bits.name}" for bits in source.parts)
            wrong = np.logical_or.reduce([bad.get(signal, sound) for signal in signals])
            reading = readings[source.name]
            self.tally.refused[source.name] += int(np.count_nonzero(wrong[reading.row]))
            readings[source.name] = reading.where(~wrong[reading.row])

    def _frames_of(self, message: Layout, frames: Frames) -> Index:
        """Indices of the sound frames of one message."""
        index = np.flatnonzero(frames.key == message.key)
        short = frames.dlc[index] != message.length
        self.tally.skip(f"wrong length {message.name}", np.count_nonzero(short))
        index = index[~short]
        if message.name in self.checksums and len(index):
            data = frames.data[index, : message.length]
            wrong = frame_checksum(message.id, data) != data[:, 0]
            self.tally.skip(f"checksum wrong {message.name}", np.count_nonzero(wrong))
            index = index[~wrong]
        if message.name in self.counters and len(index):
            bits = self.counters[message.name]
            numbers = bits.count(words_of(frames.data[index]))
            missing = lost(numbers, self._counted.get(message.name), bits.modulus)
            self.tally.skip(f"lost {message.name} (by its counter)", missing)
            self._counted[message.name] = int(numbers[-1])
        return np.asarray(index)

    def mismatch(self, frames: Frames) -> str:
        """If no frame has an id that the rig file uses: which ids there are and which were expected; else empty."""
        keys = np.unique(frames.key).tolist()
        if {message.key for message in self.used}.intersection(keys):
            return ""
        ids = [id_of(key) for key in keys]
        wanted = [f"{id_of(message.key)} ({message.name})" for message in self.used]
        return f"ids {few(ids)}; expected {few(wanted)} as in {self.dbc.path.name}"

    def _account(self, frames: Frames) -> None:
        """Count frames that the rig file does not use."""
        for key, count in zip(*(column.tolist() for column in np.unique(frames.key, return_counts=True)), strict=True):
            message = self.dbc.by_key.get(key)
            if message is None:
                self.tally.skip(f"unknown id {id_of(key)}", count)
            elif message not in self.used:
                self.tally.skip(f"not in the rig file {message.name}", count)
