"""Which message closes a scan of the thermometers, and what of counters and checksums holds on the recording.

Nothing here is taken by its name: a checksum is one that is right, a counter one that counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ballscrew.new_rig.bus_log import BusLog
from ballscrew.new_rig.growth import ok_text
from ballscrew.new_rig.seen import Guess
from ballscrew.new_rig.temperatures import THERMOMETER
from drivers.decode.checks import crc16_ccitt_false, frame_checksum
from drivers.decode.dbc import Bits
from drivers.frames import Array, words_of

_SAME = 0.02  # share by which two messages of one scan differ in number
_SOON = 0.1  # ticks from the last of the thermometers to what closes their scan
_HOLDS = 0.98  # share of frames
_FEW = 20  # frames that show whether something holds


@dataclass(frozen=True)
class ScanGuess:
    """What goes under [log] of rig.toml, and why it closes there."""

    closes: str | None = None
    scan: tuple[str, ...] = ()
    scan_state: str | None = None
    scan_crc: str | None = None
    scan_number: str | None = None
    checksums: tuple[str, ...] = ()
    counters: tuple[str, ...] = ()
    why: str = ""


def scan_of(log: BusLog, guesses: Sequence[Guess], tick_s: float) -> ScanGuess:
    """How the thermometers' messages make up scans."""
    used = list(dict.fromkeys(one.message for guess in guesses for one in guess.seen))
    thermal = dict.fromkeys(g.seen[0].message for g in guesses if g.role == THERMOMETER)
    times = {name: log.of(name).time for name in log.dbc.messages if name in {m.name for m in log.messages}}
    order = _in_order([name for name in thermal if times[name].size], times, tick_s)
    last = order[-1] if order else None
    closing = _closing(log, last, {*used}, times, tick_s) if last else None
    whole = [*used, closing] if closing and closing not in used else used
    sums = tuple(source for name in whole for source in _checksums(log, name))
    counters = tuple(source for name in whole for source in _counters(log, name))
    if last is None:
        why = "thermometers come at no common time: the tick's timer closes"
        return ScanGuess(checksums=sums, counters=counters, why=why)
    if closing is None:
        return ScanGuess(last, checksums=sums, counters=counters, why="the last message with thermometers in each tick")
    numbers = [source for source in counters if _bits(log, source).modulus >= 256]
    number = next((source for source in numbers if source.startswith(f"{closing}.")), None)
    counters = tuple(source for source in counters if source != number)
    crc = _crc(log, closing, order)
    state = next((f"{s.source} = {text}" for s in log.seen if s.message == closing and (text := ok_text(s))), None)
    why = f"it comes right behind {last} in each tick"
    return ScanGuess(closing, tuple(order), state, crc, number, sums, counters, why)


def _in_order(names: Sequence[str], times: dict[str, Array], tick_s: float) -> list[str]:
    """The messages in the order in which they come within a tick; nothing where they come at any time in it."""
    most = max((len(times[name]) for name in names), default=0)
    together = [name for name in names if len(times[name]) > (1 - _SAME) * most]
    if most < 2 or len(together) < len(names):
        return []
    stamps = np.concatenate([times[name] for name in names])
    which = np.concatenate([np.full(len(times[name]), k) for k, name in enumerate(names)])
    order = np.argsort(stamps, kind="stable")
    stamps, which = stamps[order], which[order]
    begins = np.flatnonzero(np.concatenate(([True], np.diff(stamps) > tick_s / 3)))
    whole = [tuple(burst) for burst in np.split(which, begins[1:]) if len(burst) == len(names)]
    if len(whole) < 0.8 * most:
        return []
    usual = max(set(whole), key=whole.count)
    return [names[k] for k in usual] if len({*usual}) == len(names) else []


def _closing(log: BusLog, last: str, used: set[str], times: dict[str, Array], tick_s: float) -> str | None:
    """The message without a measured value that comes soonest behind the last thermometers, once each time."""
    best: tuple[float, str] | None = None
    for message in log.messages:
        name = message.name
        if name in used or any(bits.unit for bits in message.signals.values()):
            continue
        if abs(len(times[name]) / len(times[last]) - 1) > _SAME:
            continue
        place = np.searchsorted(times[name], times[last])
        inside = place < len(times[name])
        delay = float(np.median(times[name][place[inside]] - times[last][inside])) if inside.any() else np.inf
        if delay < _SOON * tick_s and (best is None or delay < best[0]):
            best = delay, name
    return best[1] if best else None


def _checksums(log: BusLog, name: str) -> list[str]:
    layout, frames = log.dbc.messages[name], log.of(name)
    first = [s.name for s in layout.signals.values() if (s.shift, s.length, s.big_endian) == (0, 8, False)]
    if not first or len(frames) < _FEW:
        return []
    data = frames.data[:, : layout.length]
    good = np.mean(frame_checksum(layout.id, data) == data[:, 0]) > _HOLDS and len({*data[:, 0].tolist()}) > 2
    return [f"{name}.{first[0]}"] if good else []


def _counters(log: BusLog, name: str) -> list[str]:
    """Signals that count the frames of a message."""
    layout, words = log.dbc.messages[name], words_of(log.of(name).data)
    return [f"{name}.{bits.name}" for bits in layout.signals.values() if _counts(bits, bits.raw(words))]


def _counts(bits: Bits, raw: Array) -> bool:
    if bits.real or bits.unit or bits.selector or bits.length < 2 or bits.length > 32 or len(raw) < _FEW:
        return False
    steps = np.mod(np.diff(raw.astype(np.int64)), bits.modulus)
    return bool(np.mean(steps == 1) > _HOLDS)


def _crc(log: BusLog, closing: str, order: Sequence[str]) -> str | None:
    """The signal of the closing message that is the CRC-16 over the scan's bytes."""
    end = log.of(closing)
    parts = [log.of(name) for name in order]
    before = [np.searchsorted(part.time, end.time, side="right") - 1 for part in parts]
    whole = np.logical_and.reduce([k >= 0 for k in before])
    if whole.sum() < _FEW:
        return None
    lengths = [log.dbc.messages[name].length for name in order]
    data = [p.data[k[whole], :length] for p, k, length in zip(parts, before, lengths, strict=True)]
    right, words = crc16_ccitt_false(np.concatenate(data, axis=1)), words_of(end.data[whole])
    for bits in log.dbc.messages[closing].signals.values():
        if bits.length == 16 and np.mean(bits.raw(words).astype(np.int64) == right) > 0.9:
            return f"{closing}.{bits.name}"
    return None


def _bits(log: BusLog, source: str) -> Bits:
    message, _, signal = source.partition(".")
    return log.dbc.messages[message].signals[signal]
