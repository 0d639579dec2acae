"""A run as files: its frames in the format of the suffix, its truth and its machine beside them."""

import json
from collections.abc import Mapping
from pathlib import Path

import can
import numpy as np

from drivers.virtual_rig.frames.frames import EPOCH_S, FrameTable, frame_table, status_times
from drivers.virtual_rig.machine.geometry import CHANNELS, TABLE_MM
from drivers.virtual_rig.population.draw import described
from drivers.virtual_rig.run import Run

THERMOMETERS = {f"T{n + 1:02d}": n for n in range(CHANNELS)}


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
    write_beside(run, path, status_times(run.truth.time_s) - sent.time_s[0])
    return path


def write_beside(run: Run, path: Path, closes_s: np.ndarray, thermometers: Mapping[str, int] = THERMOMETERS) -> None:
    """Write what was true beside a recording: its truth and its constants.

    closes_s      (K,) when each tick closes, s since the first frame
    thermometers  the channel of each, by its name
    """
    write_truth(run, closes_s, path.with_name(f"{path.stem}.truth.csv"), thermometers)
    constants = json.dumps(described(run.machine), indent=2)
    path.with_name(f"{path.stem}.machine.json").write_text(constants + "\n", encoding="utf-8")


def candump(sent: FrameTable, began_s: float = EPOCH_S) -> str:
    """candump's log format: (seconds) can0 ID#DATA"""
    frames = zip(sent.time_s.tolist(), sent.id.tolist(), sent.data, strict=True)
    return "".join(
        f"({began_s + t:.6f}) can0 {frame_id:03X}#{data.tobytes().hex().upper()}\n" for t, frame_id, data in frames
    )


def write_truth(run: Run, closes_s: np.ndarray, path: Path, thermometers: Mapping[str, int]) -> None:
    """One row per tick: seconds since the first frame, elongation (um), true rises at the channels (K), error at the
    table were it at the place in the column's name (um)"""
    rises = run.truth.rises[:, list(thermometers.values())]
    rows = np.column_stack([closes_s, run.truth.elongation_um, rises, run.truth.table_um])
    columns = ["time_s", "elongation_um", *thermometers, *(f"table_{at:g}_um" for at in TABLE_MM)]
    digits = ["%.4f", *["%.5f"] * (len(columns) - 1)]
    np.savetxt(path, rows, fmt=digits, delimiter=",", header=",".join(columns), comments="")
