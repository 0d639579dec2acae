"""A run as files: its frames in the format of the suffix, its truth and its machine beside them."""

import json
from pathlib import Path

import can
import numpy as np

from drivers.virtual_rig.frames.frames import EPOCH_S, FrameTable, frame_table, status_times
from drivers.virtual_rig.machine.geometry import CHANNELS, TABLE_MM
from drivers.virtual_rig.population.draw import described
from drivers.virtual_rig.run import Run

TRUTH_COLUMNS = [
    "time_s", "elongation_um", *(f"T{n:02d}" for n in range(1, CHANNELS + 1)), *(f"table_{at:g}_um" for at in TABLE_MM)
]  # fmt: skip


def write(run: Run, path: str | Path, began_s: float = EPOCH_S) -> Path:
    """Write a run: frames, truth as NAME.truth.csv, constants as NAME.machine.json; returns the path of the frames.

    began_s  when it began, s since 1970
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    sent = frame_table(run)
    if path.suffix == ".log":
        path.write_text(candump(sent, began_s), encoding="ascii")
    else:
        with can.Logger(path) as writer:
            for message in sent.messages(began_s):
                writer.on_message_received(message)
    write_truth(run, sent, path.with_name(f"{path.stem}.truth.csv"))
    constants = json.dumps(described(run.machine), indent=2)
    path.with_name(f"{path.stem}.machine.json").write_text(constants + "\n", encoding="utf-8")
    return path


def candump(sent: FrameTable, began_s: float = EPOCH_S) -> str:
    """candump's log format: (seconds) can0 ID#DATA"""
    frames = zip(sent.time_s.tolist(), sent.id.tolist(), sent.data, strict=True)
    return "".join(
        f"({began_s + t:.6f}) can0 {frame_id:03X}#{data.tobytes().hex().upper()}\n" for t, frame_id, data in frames
    )


def write_truth(run: Run, sent: FrameTable, path: Path) -> None:
    """One row per tick: seconds since the first frame, elongation (um), true rises at the channels (K), error at the
    table were it at the place in the column's name (um)"""
    clock = status_times(run.truth.time_s) - sent.time_s[0]
    rows = np.column_stack([clock, run.truth.elongation_um, run.truth.rises, run.truth.table_um])
    digits = ["%.4f", *["%.5f"] * (len(TRUTH_COLUMNS) - 1)]
    np.savetxt(path, rows, fmt=digits, delimiter=",", header=",".join(TRUTH_COLUMNS), comments="")
