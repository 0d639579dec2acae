"""The live road: frames one by one into samples, by the same clock, ticks and decoder as a whole log."""

from collections.abc import Iterator

import numpy as np

from drivers.budget import Budget
from drivers.decode.addresses import Addresses
from drivers.decode.clock import RigClock
from drivers.decode.decode import Decoder
from drivers.decode.ticks import Ticks
from drivers.frames import FRAME, LATEST_S, PACKED, Frames, Tally, plausible
from estimator.record import Sample
from estimator.rig import Rig

MOST_OPEN = 500_000  # frames of one tick: a minute of a full bus


class Ticker:
    """Feed frames as they come; a sample comes out when its tick closes.

    `tally` holds what was skipped, by reason, and sentences about jumps of the clock and the like.
    """

    def __init__(self, rig: Rig, tally: Tally | None = None, budget: Budget | None = None) -> None:
        self.tally = tally or Tally()
        self.decoder = Decoder(rig, self.tally)
        self.addresses = Addresses(self.decoder.used, self.decoder.dbc, self.tally)
        modulus, budget = self.decoder.scan.modulus, budget or Budget()
        self.clock = RigClock(rig.tick_s, modulus, self.tally, lambda frame: f"frame {frame[0] + 1}", budget)
        self.ticks = Ticks(rig.tick_s, rig.log.closes is not None)
        self.frames = 0
        self._open: list[tuple[int, bytes, float]] = []

    def feed(self, time_s: float, can_id: int, extended: bool, data: bytes) -> Iterator[Sample]:
        """Take one data frame, stamped on the bus's clock in s; the samples of the ticks that it closed.

        After a silence of an hour these are thousands: each is made when it is asked for.
        """
        can_id = self.addresses.id_of(can_id, extended)
        if (can_id, extended) in self.decoder.own:
            self.tally.skip("sent by us")
            return iter(())
        size = len(data)
        if not (0 <= time_s < LATEST_S and 0 <= can_id <= (0x1FFFFFFF if extended else 0x7FF) and size <= 8):
            plausible(
                _frames([PACKED.pack(time_s, can_id & 0xFFFFFFFF, extended, min(size, 9), b"", 0, 0)]), self.tally
            )
            return iter(())
        packed = PACKED.pack(time_s, can_id, extended, size, bytes(data), 0, 0)
        scan = self.decoder.closing(can_id, extended, data)
        frame = self.frames, packed, scan is not None
        self.frames += 1
        return self._placed(self.clock.step(frame, time_s, scan is not None, -1 if scan is None else scan))

    def advance(self, time_s: float) -> Iterator[Sample]:
        """No frame came until `time_s` on the bus's clock: close the ticks whose timer ran out."""
        self.clock.advance(time_s)
        return self._timed(self.ticks.due(self.clock.now))

    def flush(self) -> Iterator[Sample]:
        """The frames end here: the open tick too, if it lasted."""
        yield from self._placed(self.clock.flush())
        yield from self._timed(self.ticks.rest(self.clock.now))
        self.tally.skip("after the last whole tick", len(self._open))
        self._open = []

    def _placed(self, placed: list[tuple[tuple[int, bytes, bool], float]]) -> Iterator[Sample]:
        for (number, packed, closes), now in placed:
            yield from self._timed(self.ticks.due(now))
            if len(self._open) < MOST_OPEN:
                self._open.append((number, packed, now))
            else:
                self.tally.skip("too many frames in one tick")
            if closes and self.ticks.close(now):
                yield from self._close(now)
            elif closes:
                self.tally.skip("closing message too soon (used)")

    def _timed(self, ticks: list[tuple[float, float]]) -> Iterator[Sample]:
        return (sample for _, date in ticks for sample in self._close(date))

    def _close(self, date: float) -> list[Sample]:
        """The open frames make one tick."""
        frames = _frames([packed for _, packed, _ in self._open])
        now = np.array([now for _, _, now in self._open])
        first = self._open[0][0] if self._open else 0
        self._open = []
        return list(self.decoder.rows(frames, first, now, np.zeros(len(now), np.intp), np.array([date])))


def _frames(packed: list[bytes]) -> Frames:
    return Frames.of([np.frombuffer(b"".join(packed), FRAME)], "frame")
