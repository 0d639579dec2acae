"""A log of CAN frames of a rig that nobody has described yet: the messages of its DBC that came, signal by signal."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ballscrew.new_rig.seen import Seen
from drivers.budget import Budget
from drivers.decode.addresses import addressed
from drivers.decode.buses import chosen, on_one_clock
from drivers.decode.dbc import Bits, Dbc, Layout, Words, load_dbc
from drivers.frames import Frames, Tally, few, id_of, words_of
from drivers.logs.joined import Progress
from drivers.logs.logs import read_log
from estimator.errors import SetupError

OURS = Path(__file__).parents[2] / "drivers" / "rig.dbc"
_SHOWN = 8  # ids in an error


@dataclass(frozen=True)
class BusLog:
    """Frames of the rig's bus, the messages among them, and their signals.

    never  messages of the DBC that did not come
    bus    that it is, "" where there is one only     others  on which the same messages come
    """

    path: Path
    frames: Frames
    dbc: Dbc
    messages: tuple[Layout, ...]
    never: tuple[str, ...]
    seen: tuple[Seen, ...]
    bus: str = ""
    others: tuple[str, ...] = ()

    def of(self, message: str) -> Frames:
        """The whole frames of a message."""
        layout = self.dbc.messages[message]
        return self.frames.take((self.frames.key == layout.key) & (self.frames.dlc == layout.length))


def read_bus_log(
    path: Path, dbc_path: Path | None, tally: Tally, progress: Progress | None = None, bus: str | int | None = None
) -> BusLog:
    """Read a log, of `bus` where it is known; without a DBC one with the ids of that which ships with us.

    Else a SetupError.
    """
    return bus_log_of(path, read_log(path, tally, Budget(), progress), dbc_path, tally, bus)


def bus_log_of(path: Path, frames: Frames, dbc_path: Path | None, tally: Tally, bus: str | int | None) -> BusLog:
    """The same of frames that are read."""
    frames = frames.take(chosen(frames, bus, str(path)))
    dbc = load_dbc(dbc_path or OURS)
    theirs = [message for message in dbc.messages.values() if not message.own and not message.broken]
    theirs = [message for message in theirs if message.signals and message.length <= 8]
    frames = addressed(frames, theirs, dbc, str(path), tally)
    there = set(np.unique(frames.key).tolist())
    came = [message for message in theirs if message.key in there]
    if dbc_path is None and len(came) < len(theirs) - 1:
        raise SetupError(f"{path}: {_ids(frames)}; what they mean says the DBC of the bus: --dbc FILE.dbc")
    if not came:
        wanted = ", ".join(f"{id_of(m.key)} ({m.name})" for m in theirs[:4])
        raise SetupError(f"{dbc.path}: none of its ids, {wanted} ..., is in {path.name}: {_ids(frames)}")
    bus, others = _bus(frames, came)
    frames = frames.take(frames.bus == bus) if others else frames.on_clock(on_one_clock(frames, str(path), tally))
    seen = [signal for message in came for signal in _signals(message, frames)]
    never = tuple(message.name for message in theirs if message not in came)
    name = frames.buses[bus].partition(" = ")[0] if others else ""
    return BusLog(path, frames, dbc, tuple(came), never, tuple(seen), name, others)


def _bus(frames: Frames, came: Sequence[Layout]) -> tuple[int, tuple[str, ...]]:
    """The bus with the most of these messages, and the others where one comes on several."""
    on: Counter[int] = Counter()
    for message in came:
        on.update(np.unique(frames.bus[frames.key == message.key]).tolist())
    first = max(on, key=lambda bus: (on[bus], -bus))
    both = sum(on.values()) > len(came)
    return first, tuple(frames.buses[bus] for bus in sorted(on) if bus != first) if both else ()


def _signals(message: Layout, frames: Frames) -> list[Seen]:
    """The signals of a message that were ever read."""
    index = np.flatnonzero((frames.key == message.key) & (frames.dlc == message.length))
    words, time = words_of(frames.data[index]), frames.time[index]
    order = np.argsort(time, kind="stable")
    found = [_signal(message, bits, words, time, order) for bits in message.signals.values()]
    return [signal for signal in found if len(signal.time)]


def _signal(message: Layout, bits: Bits, words: Words, time: np.ndarray, order: np.ndarray) -> Seen:
    raw = bits.raw(words)
    value = bits.physical(raw)
    use = bits.present(words) & np.isfinite(value) & ~np.isin(raw, list(bits.no_value))
    rows = order[use[order]]
    return Seen(f"{message.name}.{bits.name}", bits.unit, time[rows], value[rows], raw[rows], bits.texts)


def _ids(frames: Frames) -> str:
    """Which ids came how often, in words: the most frequent first."""
    keys, counts = np.unique(frames.key, return_counts=True)
    span = max(float(np.ptp(frames.time)), 1e-3)
    order = np.argsort(-counts, kind="stable")
    told = [f"{id_of(int(keys[k]))} {counts[k] / span:.3g}/s" for k in order]
    return f"{len(frames)} frames of {len(keys)} ids ({few(told, _SHOWN)})"
