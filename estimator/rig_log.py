"""How a rig's logs are read: CAN by messages, lab CSVs by columns."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Csv:
    """What a lab CSV's reader cannot find by itself; what is not said is found.

    separator    between cells: a character, "tab" or "space"
    decimal      mark: "." or ","
    time_format  of times as text, in strptime's letters: "%d.%m.%Y %H:%M:%S"
    time_unit    of times as numbers: "s", "ms", "us", "ns", "min", "h" or "d"
    encoding     of the text, such as "utf-16" or "cp1252"
    skip         lines before the names
    sort         rows by their times: true in any case, false never
    """

    separator: str | None = None
    decimal: str | None = None
    time_format: str | None = None
    time_unit: str | None = None
    encoding: str | None = None
    skip: int = 0
    sort: bool | None = None


@dataclass(frozen=True)
class Log:
    """How the rig's logs are read. All but `time_column` and `csv` is about CAN; signals are "Message.Signal".

    dbc          DBC file, in the rig folder or one that ships with the package
    bus          the rig's bus in a log of several: its name, or its number there
    closes       message that closes a tick
    time_column  time column of a lab CSV
    csv          what the reader of a lab CSV has to be told
    scan         messages that make one scan together with the closing message
    scan_state   condition that a closing message must meet, else its scan does not count
    scan_crc     CRC-16/CCITT-FALSE over the data bytes of the scan's messages, in their order
    scan_number  counts scans: tells a jump of the clock from silence
    fault_mask   bit n set: signal n of the scan, in its order, does not count
    checksums    CRC-8/SAE-J1850 over a frame's id (low, high byte) and data bytes 1 ..., kept in byte 0
    counters     count the frames of a message: tell lost frames
    """

    dbc: str | None = None
    bus: str | int | None = None
    closes: str | None = None
    time_column: str = "time_s"
    csv: Csv = Csv()
    scan: tuple[str, ...] = ()
    scan_state: str | None = None
    scan_crc: str | None = None
    scan_number: str | None = None
    fault_mask: str | None = None
    checksums: tuple[str, ...] = ()
    counters: tuple[str, ...] = ()
