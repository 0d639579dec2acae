"""Whether a scan counts: the closing message's state, its checksum over the data, its bits of faulty channels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.decode.checks import crc16_ccitt_false
from drivers.decode.dbc import Bits, Condition, Dbc, Layout
from drivers.frames import Frames, Tally
from estimator.errors import SetupError
from estimator.rig import Rig

Mask = NDArray[np.bool_]
Index = NDArray[np.intp]


class Scan:
    """The checks that a rig file asks for; without `log.scan` there are none."""

    def __init__(self, rig: Rig, dbc: Dbc) -> None:
        log, place = rig.log, f"{rig.folder / 'rig.toml'}: log"
        self.messages = [dbc.message(name, f"{place}.scan") for name in log.scan]
        self.closing: Layout | None = dbc.message(log.closes, f"{place}.closes") if log.closes else None
        self.state: Condition | None = dbc.condition(log.scan_state, f"{place}.scan_state") if log.scan_state else None
        if self.state:
            self._in_closing(self.state.message, f"{place}.scan_state")
        self.crc = self._bits(dbc, log.scan_crc, f"{place}.scan_crc")
        self.number = self._bits(dbc, log.scan_number, f"{place}.scan_number")
        self.faults = self._bits(dbc, log.fault_mask, f"{place}.fault_mask")

    def bad(self, frames: Frames, last: dict[str, Index], rows: int, tally: Tally) -> dict[str, Mask]:
        """Per signal of the scan ("Message.Signal"): the rows in which it does not count, (rows,) bool.

        last  per message the index of its last frame in each row, (rows,), -1 for none
        """
        signals = [f"{m.name}.{s}" for m in self.messages for s in sorted(m.signals, key=lambda s: m.signals[s].shift)]
        if not signals or self.closing is None:
            return {}
        row = np.flatnonzero(last[self.closing.name] >= 0)
        words = frames.take(last[self.closing.name][row]).words()
        whole = np.zeros(rows, bool)
        if self.state:
            whole[row] |= self._state(self.state, self.state.bits.raw(words), tally)
        if self.crc:
            whole[row] |= self._crc(self.crc.raw(words), frames, {n: i[row] for n, i in last.items()}, tally)
        bad = {signal: whole.copy() for signal in signals}
        faults = self.faults.raw(words) if self.faults else np.zeros(len(row), np.uint64)
        for bit, signal in enumerate(signals):
            faulty = (faults.astype(np.uint64) >> np.uint64(bit) & np.uint64(1)) == 1
            tally.skip(f"fault bit {signal.split('.')[1]}", np.count_nonzero(faulty & ~whole[row]))
            bad[signal][row] |= faulty
        return bad

    @staticmethod
    def _state(state: Condition, raw: NDArray[np.uint64], tally: Tally) -> Mask:
        wrong = ~state.holds(raw)
        for number in np.unique(raw[wrong]):
            text = state.bits.texts.get(int(number), "unknown")
            tally.skip(f"scan with {state.bits.name} {text}", np.count_nonzero(raw[wrong] == number))
        return wrong

    def _crc(self, told: NDArray[np.uint64], frames: Frames, last: dict[str, Index], tally: Tally) -> Mask:
        """Where the checksum is wrong; a scan that lost a frame cannot be checked and counts."""
        index = np.stack([last[message.name] for message in self.messages], axis=1)
        whole = (index >= 0).all(axis=1)
        tally.skip("scan incomplete, its checksum not checked (used)", np.count_nonzero(~whole))
        data = np.concatenate([frames.data[index[whole, k], : m.length] for k, m in enumerate(self.messages)], axis=1)
        wrong = np.zeros(len(told), bool)
        wrong[whole] = crc16_ccitt_false(data) != told[whole]
        tally.skip("scan checksum wrong", np.count_nonzero(wrong))
        return wrong

    def _bits(self, dbc: Dbc, dotted: str | None, place: str) -> Bits | None:
        if dotted is None:
            return None
        message, bits = dbc.signal(dotted, place)
        self._in_closing(message.name, place)
        return bits

    def _in_closing(self, message: str, place: str) -> None:
        if self.closing is None or message != self.closing.name:
            closing = self.closing.name if self.closing else "log.closes, which is missing"
            raise SetupError(f"{place}: must be a signal of the closing message ({closing}), not of {message}")
