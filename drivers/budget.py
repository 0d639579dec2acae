"""How much one file may cost: an endless, looping or inflating log ends here instead of taking the machine with it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Budget:
    """Limits of one reading. A file that reaches one is read up to there, and the recording says so.

    frames   at 100 per second, 10 million are a day
    seconds  processor time of the reading: how long it takes on a busy machine is no fault of the file
    stall_s  processor time without a frame from a reader in its own process
    size     bytes read of a text log
    memory   bytes of address space of a reader in its own process
    ticks    rows of a recording, also those of a gap
    gap_s    a longer silence ends the recording
    """

    frames: int = 10_000_000
    seconds: float = 300.0
    stall_s: float = 10.0
    size: int = 2_000_000_000
    memory: int = 1_500_000_000
    ticks: int = 200_000
    gap_s: float = 3600.0

    def spent(self, frames: int, size: int, late: bool) -> str:
        """Which limit of a reading is used up, as a clause; empty while none is."""
        if frames >= self.frames:
            return f"{self.frames} frames are the most that one recording may hold"
        if size >= self.size:
            return f"{self.size} bytes are the most that one recording may hold"
        return f"reading took {self.seconds:g} s" if late else ""
