"""Whether a scan counts: the closing message's state, its checksum over the data, its bits of faulty channels."""

import numpy as np
from numpy.typing import NDArray

from drivers.decode.checks import crc16_ccitt_false
from drivers.decode.dbc import Bits, Condition, Dbc, Layout, Words
from drivers.frames import Frames, Index, Mask, Tally, Whole, words_of
from estimator.errors import SetupError
from estimator.rig import Rig


class Scan:
    """The checks that a rig file asks for; without `log.scan` there are none."""

    def __init__(self, rig: Rig, dbc: Dbc) -> None:
        log, key = rig.log, f"{rig.folder / 'rig.toml'}: log"
        self.messages = [dbc.message(name, f"{key}.scan") for name in log.scan]
        self.closing: Layout | None = dbc.message(log.closes, f"{key}.closes") if log.closes else None
        self.state: Condition | None = dbc.condition(log.scan_state, f"{key}.scan_state") if log.scan_state else None
        if self.state:
            self._in_closing(self.state.message, f"{key}.scan_state")
        self.crc = self._bits(dbc, log.scan_crc, f"{key}.scan_crc")
        self.number = self._bits(dbc, log.scan_number, f"{key}.scan_number")
        self.faults = self._bits(dbc, log.fault_mask, f"{key}.fault_mask")

    @property
    def modulus(self) -> int:
        """After how many scans their number starts again."""
        return self.number.modulus if self.number else 1

    def numbers(self, words: Words) -> Whole:
        """Scan numbers of closing messages, (n,), -1 where they carry none."""
        return self.number.count(words) if self.number else np.full(len(words[0]), -1, np.int64)

    def bad(self, frames: Frames, last: dict[str, Index], rows: int, tally: Tally) -> dict[str, Mask]:
        """Per signal of the scan ("Message.Signal"): the rows in which it does not count, (rows,) bool.

        last  per message the index of its last frame in each row, (rows,), -1 for none
        """
        signals = [f"{m.name}.{s}" for m in self.messages for s in sorted(m.signals, key=lambda s: m.signals[s].shift)]
        if not signals or self.closing is None:
            return {}
        row = np.flatnonzero(last[self.closing.name] >= 0)
        words = words_of(frames.data[last[self.closing.name][row]])
        whole = np.zeros(rows, bool)
        if self.state:
            for text, wrong in self.state.broken(words, "unknown"):
                tally.skip(f"scan with {self.state.bits.name} {text}", np.count_nonzero(wrong))
                whole[row] |= wrong
        if self.crc:
            whole[row] |= self._crc(self.crc.raw(words), frames, {n: i[row] for n, i in last.items()}, tally)
        bad = {signal: whole.copy() for signal in signals}
        faults = self.faults.raw(words) if self.faults else np.zeros(len(row), np.uint64)
        for bit, signal in enumerate(signals):
            faulty = (faults.astype(np.uint64) >> np.uint64(bit) & np.uint64(1)) == 1
            tally.skip(f"fault bit {signal.split('.')[1]}", np.count_nonzero(faulty & ~whole[row]))
            bad[signal][row] |= faulty
        return bad

    def _crc(self, stated: NDArray[np.uint64], frames: Frames, last: dict[str, Index], tally: Tally) -> Mask:
        """Where the checksum is wrong; a scan that lost a frame cannot be checked and counts."""
        index = np.stack([last[message.name] for message in self.messages], axis=1)
        whole = (index >= 0).all(axis=1)
        tally.skip("scan incomplete, its checksum not checked (used)", np.count_nonzero(~whole))
        data = np.concatenate([frames.data[index[whole, k], : m.length] for k, m in enumerate(self.messages)], axis=1)
        wrong = np.zeros(len(stated), bool)
        wrong[whole] = crc16_ccitt_false(data) != stated[whole]
        tally.skip("scan checksum wrong", np.count_nonzero(wrong))
        return wrong

    def _bits(self, dbc: Dbc, dotted: str | None, key: str) -> Bits | None:
        if dotted is None:
            return None
        message, bits = dbc.signal(dotted, key)
        self._in_closing(message.name, key)
        return bits

    def _in_closing(self, message: str, key: str) -> None:
        if self.closing is None or message != self.closing.name:
            closing = self.closing.name if self.closing else "log.closes, which is missing"
            raise SetupError(f"{key}: must be a signal of the closing message ({closing}), not of {message}")
