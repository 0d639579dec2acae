"""A run as files: its frames in the format of the suffix, its truth beside them."""

from pathlib import Path
from typing import TYPE_CHECKING

import can
import numpy as np

from drivers.virtual_rig.frames import frames
from drivers.virtual_rig.frames.frames import FrameTable
from drivers.virtual_rig.machine.geometry import CHANNELS

if TYPE_CHECKING:
    from drivers.virtual_rig.run import Run

TRUTH_COLUMNS = ["time_s", "elongation_um", *(f"T{n:02d}" for n in range(1, CHANNELS + 1))]


def write(run: "Run", path: Path) -> Path:
    """Frames and truth of a run; returns the path of the frames."""
    path.parent.mkdir(parents=True, exist_ok=True)
    sent = frames.table(run)
    if path.suffix == ".log":
        path.write_text(candump(sent), encoding="ascii")
    else:
        _write_with_python_can(sent, path)
    write_truth(run, sent, path.with_name(f"{path.stem}.truth.csv"))
    return path


def candump(sent: FrameTable) -> str:
    """candump's log format: (seconds) can0 ID#DATA"""
    digits = sent.data.tobytes().hex().upper()
    lines = [
        f"({frames.EPOCH_S + t:.6f}) can0 {frame_id:03X}#{digits[16 * k : 16 * k + 16]}\n"
        for k, (t, frame_id) in enumerate(zip(sent.time_s.tolist(), sent.id.tolist(), strict=True))
    ]
    return "".join(lines)


def _write_with_python_can(sent: FrameTable, path: Path) -> None:
    with can.Logger(str(path)) as writer:
        for message in frames.messages(sent):
            writer.on_message_received(message)


def write_truth(run: "Run", sent: FrameTable, path: Path) -> None:
    """One row per tick: seconds since the first frame, elongation (um), true rises at the channels (K)"""
    clock = frames.status_times(run.truth.time_s) - sent.time_s[0]
    rows = np.column_stack([clock, run.truth.elongation_um, run.truth.rises])
    digits = ["%.4f", *["%.5f"] * (CHANNELS + 1)]
    np.savetxt(path, rows, fmt=digits, delimiter=",", header=",".join(TRUTH_COLUMNS), comments="")
