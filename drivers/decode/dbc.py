"""The DBC as numpy needs it: where each signal's bits are, and what its numbers mean."""

import operator
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.frames import Array, Mask, Whole, key_of
from drivers.mended import read_dbc
from estimator.errors import SetupError, nearest

Words = tuple[NDArray[np.uint64], NDArray[np.uint64]]  # data bytes little-endian, big-endian

# Texts of a value table that say that a number is no measurement.
_NO_VALUE = re.compile(
    r"not.?avail|n/a|^s?na$|fault|error|invalid|not.?valid|no.?(data|value|signal)|undefined|reserved", re.IGNORECASE
)
OURSELVES = "Ballscrew"  # the node of a DBC that sends the estimate
_CONDITION = re.compile(r"\s*(\w+)\.(\w+)\s*(=|==|!=|<=|>=|<|>)\s*(.+?)\s*")
_COMPARE: dict[str, Callable[[Any, Any], Any]] = {"=": operator.eq, "==": operator.eq, "!=": operator.ne}
_COMPARE |= {"<": operator.lt, ">": operator.gt, "<=": operator.le, ">=": operator.ge}


@dataclass(frozen=True)
class Bits:
    """One signal: where it is in the frame, its scaling and the texts of its value table.

    unit     as the DBC writes it
    highest  largest number on the wire by the DBC
    """

    name: str
    shift: int
    length: int
    big_endian: bool = False
    signed: bool = False
    real: bool = False
    scale: float = 1.0
    offset: float = 0.0
    unit: str = ""
    highest: float | None = None
    texts: Mapping[int, str] = field(default_factory=dict)
    selector: "Bits | None" = None
    selected: tuple[int, ...] = ()

    def raw(self, words: Words) -> NDArray[Any]:
        """The numbers on the wire, (n,): int64, uint64 or float."""
        word = words[self.big_endian]
        if self.signed and not self.real:
            left = (word << np.uint64(64 - self.shift - self.length)).view(np.int64)
            return left >> np.int64(64 - self.length)
        plain = (word >> np.uint64(self.shift)) & np.uint64((1 << self.length) - 1)
        if self.real:
            bits, kind = {16: ("<u2", "<f2"), 32: ("<u4", "<f4"), 64: ("<u8", "<f8")}[self.length]
            with np.errstate(invalid="ignore"):  # a signalling NaN is a NaN
                return plain.astype(bits).view(kind).astype(float)
        return plain

    def physical(self, raw: NDArray[Any]) -> Array:
        """Numbers in the DBC's unit, (n,)."""
        return raw.astype(float) * self.scale + self.offset

    def present(self, words: Words) -> Mask:
        """Where the signal is in the frame, (n,): always, unless it is multiplexed."""
        if self.selector is None:
            return np.ones(len(words[0]), bool)
        return np.isin(self.selector.raw(words).astype(np.int64), self.selected)

    @property
    def modulus(self) -> int:
        """After how many numbers a counter starts again: one more than its maximum in the DBC, else by its width."""
        by_width = 1 << min(self.length, 62)
        return min(int(self.highest) + 1, by_width) if self.highest and not self.signed else by_width

    def count(self, words: Words) -> Whole:
        """The numbers of a counter, (n,), 0 ... modulus - 1: also of one that the DBC calls signed."""
        return self.raw(words).astype(np.int64) % self.modulus

    @cached_property
    def no_value(self) -> dict[int, str]:
        """Raw numbers that say "not available", "fault" and the like, with the table's text."""
        return {raw: text for raw, text in self.texts.items() if _NO_VALUE.search(text)}


@dataclass(frozen=True)
class Layout:
    """One message: signals in the order of their bits.

    cycle_s  how often it comes, 0 where it is not cyclic
    own      whether we send it, and not the rig
    broken   what is wrong with it, in words; it has no signals then
    """

    name: str
    id: int
    extended: bool
    length: int
    signals: Mapping[str, Bits]
    cycle_s: float = 0.0
    own: bool = False
    broken: str = ""

    @property
    def key(self) -> int:
        """As `Frames.key`."""
        return key_of(self.id, self.extended)


@dataclass(frozen=True)
class Condition:
    """ "Message.Signal = value": what a flag must say for a reading to count."""

    message: str
    bits: Bits
    compare: str
    value: float

    def holds(self, raw: NDArray[Any]) -> Mask:
        """Where the raw numbers meet it, (n,)."""
        return np.asarray(_COMPARE[self.compare](raw.astype(float), self.value))

    def broken(self, words: Words, unknown: str) -> Iterator[tuple[str, Mask]]:
        """What else it says, as the DBC's text or `unknown`, and where, (n,)."""
        raw = self.bits.raw(words)
        for number in np.unique(raw[~self.holds(raw)]):
            yield self.bits.texts.get(int(number), unknown), raw == number


class Dbc:
    """All messages of one DBC file; what it lacks is a SetupError that names the rig file's key."""

    def __init__(self, path: Path, messages: Mapping[str, Layout], left_out: Mapping[str, str]) -> None:
        self.path, self.left_out = path, left_out
        self.messages = messages
        self.by_key = {message.key: message for message in messages.values()}

    def message(self, name: str, key: str) -> Layout:
        """A message by name; `key` is the rig file's that asks for it."""
        if name in self.left_out:
            raise SetupError(f"{key}: message '{name}' of {self.path.name} is broken: {self.left_out[name]}")
        if name not in self.messages:
            raise SetupError(f"{key}: {self.path.name} has no message '{name}'; {nearest(name, self.messages)}")
        message = self.messages[name]
        if message.broken:
            raise SetupError(f"{key}: message '{name}' of {self.path.name} is broken: {message.broken}")
        if message.length > 8:
            raise SetupError(f"{key}: message '{name}' has {message.length} bytes; CAN FD frames are not read")
        return message

    def signal(self, dotted: str, key: str) -> tuple[Layout, Bits]:
        """A signal by "Message.Signal"."""
        name, _, signal = dotted.partition(".")
        message = self.message(name, key) if name in {*self.messages, *self.left_out} else None
        if message and signal in message.signals:
            return message, message.signals[signal]
        known = [f"{m.name}.{s}" for m in self.messages.values() for s in m.signals]
        raise SetupError(f"{key}: {self.path.name} has no signal '{dotted}'; {nearest(dotted, known)}")

    def condition(self, text: str, key: str) -> Condition:
        """A condition such as "Message.Signal = 0" or "Message.Signal = Ok"."""
        match = _CONDITION.fullmatch(text)
        if not match:
            raise SetupError(f"{key}: '{text}' is no condition; expected for example 'Message.Signal = 0'")
        message, bits = self.signal(f"{match[1]}.{match[2]}", key)
        known = {label: raw for raw, label in bits.texts.items()}
        try:
            value = float(known.get(match[4], match[4]))
        except ValueError:
            raise SetupError(f"{key}: '{match[4]}' is no value of {bits.name}; {nearest(match[4], known)}") from None
        return Condition(message.name, bits, match[3], value)


def find_dbc(name: str | None, folder: Path) -> Path:
    """The DBC in the rig folder, else the one of the package; a rig that names none is of lab CSVs: a SetupError."""
    if name is None:
        raise SetupError(f"{folder / 'rig.toml'}: log.dbc is missing: CAN frames need a DBC file")
    folders = [folder, Path(__file__).parents[1]]
    for one in folders:
        if (one / name).is_file():
            return one / name
    raise SetupError(f"{folder / 'rig.toml'}: log.dbc: no file '{name}' in {' or '.join(map(str, folders))}")


def load_dbc(path: Path) -> Dbc:
    """Read a DBC; one that cannot be read is a SetupError."""
    return _load(path, path.stat().st_mtime_ns)


@lru_cache(maxsize=16)
def _load(path: Path, changed: int) -> Dbc:
    try:
        messages, left_out = read_dbc(path)
    except (OSError, ValueError) as error:
        raise SetupError(f"{path}: cannot be read as a DBC: {' '.join(str(error).split())}") from None
    return Dbc(path, {message.name: _layout(message) for message in messages}, left_out)


def _layout(message: Any) -> Layout:
    from drivers.canbus import cantools

    about = message.name, message.frame_id, bool(message.is_extended_frame), message.length
    try:
        message.refresh(strict=True)
    except cantools.Error as error:  # no matter, unless the rig names it
        return Layout(*about, {}, broken=" ".join(str(error).split()))
    plain = {signal.name: _bits(signal) for signal in message.signals}
    signals = {s.name: _multiplexed(s, plain) if s.multiplexer_ids else plain[s.name] for s in message.signals}
    return Layout(*about, signals, (message.cycle_time or 0) / 1e3, OURSELVES in message.senders)


def _bits(signal: Any) -> Bits:
    from cantools.database.utils import start_bit  # of a big-endian signal its highest, counted from the first byte's

    big = signal.byte_order == "big_endian"
    return Bits(
        name=signal.name,
        shift=64 - start_bit(signal) - signal.length if big else signal.start,
        length=signal.length,
        big_endian=big,
        signed=bool(signal.is_signed),
        real=bool(signal.is_float),
        scale=float(signal.scale),
        offset=float(signal.offset),
        unit=signal.unit or "",
        highest=_highest(signal),
        texts={int(raw): str(text) for raw, text in (signal.choices or {}).items()},
    )


def _highest(signal: Any) -> float | None:
    if signal.maximum is None or not signal.scale:
        return None
    return float((signal.maximum - signal.offset) / signal.scale)


def _multiplexed(signal: Any, plain: Mapping[str, Bits]) -> Bits:
    selector = plain[signal.multiplexer_signal]
    return replace(plain[signal.name], selector=selector, selected=tuple(signal.multiplexer_ids))
