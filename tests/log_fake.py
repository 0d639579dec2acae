"""Small synthetic logs for tests: whole scans of the paper's rig, then broken on purpose."""

import math
import random
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import cantools

START = 1_700_000_000.0
DBC = Path(__file__).parents[1] / "drivers" / "rig.dbc"


class Row(NamedTuple):
    """One frame: s, id, 29 bit, data."""

    time: float
    id: int
    extended: bool
    data: bytes


@cache
def database() -> Any:
    """The rig's DBC."""
    return cantools.database.load_file(DBC, strict=True)


def crc(data: bytes, polynomial: int, width: int, start: int, final: int) -> int:
    """Bit by bit, from the definition."""
    value = start
    for bit in (byte >> (7 - k) & 1 for byte in data for k in range(8)):
        top = value >> (width - 1) & 1
        value = (value << 1) & ((1 << width) - 1)
        value ^= polynomial if top ^ bit else 0
    return value ^ final


def frame(time: float, message: str, **values: float) -> Row:
    """One frame of the rig's DBC."""
    description = database().get_message_by_name(message)
    return Row(time, description.frame_id, False, description.encode(values, strict=False))


def telemeter(time: float, number: int, celsius: float = 20.0, state: int = 1, faults: int = 0) -> list[Row]:
    """One scan: T01 = celsius, T02 = celsius + 1 ..., closed by its status."""
    names = [*(f"T{n:02d}" for n in range(1, 16)), "TBoard"]
    rows = []
    for k in range(4):
        values = {name: celsius + 4 * k + j for j, name in enumerate(names[4 * k : 4 * k + 4])}
        rows.append(frame(time - 0.0012 + 0.0003 * k, f"Telemeter{k + 1}", **values))
    status = {"TelCounter": number % 15, "TelState": state, "TelScanNo": number % 65536, "TelFaultMask": faults}
    told = crc(b"".join(row.data for row in rows), 0x1021, 16, 0xFFFF, 0)
    row = frame(time, "TelemeterStatus", TelCrc=0, TelScanCrc=told, **status)
    check = crc(bytes([row.id & 255, row.id >> 8]) + row.data[1:], 0x1D, 8, 0xFF, 0xFF)
    return [*rows, row._replace(data=bytes([check]) + row.data[1:])]


def position(s: float, stroke: float = 400.0, period: float = 2.4) -> tuple[float, float]:
    """Table position, mm, and speed, rpm, of a smooth to and fro."""
    phase = 2 * math.pi * s / period
    return stroke / 2 * (1 - math.cos(phase)), stroke / 2 * math.sin(phase) * 2 * math.pi / period / 12 * 60


def log(scans: int, hertz: int = 20, moves: tuple[int, int] = (3, 10**9), seed: int = 0) -> list[Row]:
    """`scans` scans of 1 s; the table moves between the two scans `moves`. Temperatures rise 0.1 degC a scan."""
    draw = random.Random(seed)
    rows: list[Row] = []
    counter = 0
    for k in range(scans):
        begin = START + k
        moving = moves[0] <= k < moves[1]
        for j in range(hertz if moving else 1):
            s = j / hertz
            place, speed = position(k + s) if moving else (0.0, 0.0)
            values = {"DrvPosition": place, "DrvSpeed": speed, "DrvCurrent": draw.uniform(0, 5), "DrvState": 2}
            rows.append(frame(begin + s, "Drive", DrvCounter=counter % 15, **values))
            counter += 1
        at = begin + 0.99
        warm = {name: 20 + draw.random() for name in ("EnvAmbient", "EnvBase", "EnvBracketAnchor", "EnvBracketFree")}
        rows.append(frame(at, "Environment1", **warm))
        rows.append(frame(at + 0.0003, "Environment2", EnvNut=21, EnvProbe=22, EnvBar=23, EnvCounter=k % 15))
        direct = {"DspDirectSeq": k % 256, "DspDirectState": 0, "DspDirectA1B1": k * 0.1, "DspDirectA2B2": 2.0}
        rows.append(frame(at + 0.0006, "DisplacementDirect", **direct))
        if moving:
            hold = {"DspHoldSeq": k // 2 % 256, "DspHoldState": 0, "DspHoldA1B1": k * 0.2, "DspHoldA2B2": 4.0}
            rows.append(frame(begin + 0.6, "DisplacementHold", **hold))
        rows += telemeter(begin + 0.995, k, 20 + 0.1 * k)
    return sorted(rows, key=lambda row: row.time)


def text(rows: list[Row]) -> str:
    """candump text."""
    return "".join(
        f"({row.time:.6f}) can0 {row.id:0{8 if row.extended else 3}X}#{row.data.hex().upper()}\n" for row in rows
    )


def write(path: Path, rows: list[Row]) -> Path:
    """A candump log."""
    path.write_text(text(rows), encoding="ascii")
    return path
