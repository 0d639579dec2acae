"""Files that hold no text and no log of ours, whatever they are called: what they are, and the way out."""

from pathlib import Path

_CSV = "save or export it as CSV"
_UNPACK = "is compressed: unpack it first"
_BEGINS = {
    b"PK\3\4": f"is an Excel workbook or a zip archive: {_CSV}, or unpack it first",
    b"\xd0\xcf\x11\xe0": f"is an Excel workbook: {_CSV}",
    b"\x1f\x8b": _UNPACK,
    b"BZh": _UNPACK,
    b"\xfd7zXZ": _UNPACK,
    b"\x28\xb5\x2f\xfd": _UNPACK,
    b"TDSm": f"is a TDMS file of LabVIEW: {_CSV}",
    b"PAR1": f"is a Parquet table: {_CSV}",
    b"SQLite": "is an SQLite database: export its frames to .blf, .asc or candump's .log",
    b"LOGG": "is a Vector BLF log: rename it to .blf",
    b"MDF ": "is an MDF file: rename it to .mf4",
    b"UnFinMF": "is an MDF file that was not finished: rename it to .mf4",
    b"\n\r\r\n": "is a capture of Wireshark's: export its frames to .asc or candump's .log",
    b"{": f"is JSON: {_CSV}",
    b"<": f"is HTML or XML: {_CSV}",
}
_SUFFIXES = {
    "save or export it as .csv": ".xlsx .xls .xlsm .ods .tdms .parquet .json .mat .h5 .hdf5 .dxd .d7d .tdm",
    "a table as text is read as .csv, frames as candump -L writes them as .log: rename it": ".txt .dat .tsv .lvm .prn",
    "unpack it first": ".gz .zip .bz2 .xz .zst .7z .tar",
    "export its frames to .blf, .asc or candump's .log": ".db .sqlite .pcap .pcapng .mdf .ulg .kme50 .tdx .xtf",
}


def begins_as(path: Path) -> str:
    """What a file's first bytes say that it is, in words; "" where they say nothing."""
    with path.open("rb") as file:
        start = file.read(16).removeprefix(b"\xef\xbb\xbf").lstrip(b" ")
    return next((what for bytes_, what in _BEGINS.items() if start.startswith(bytes_)), "")


def way_out(suffix: str) -> str:
    """What to do with files of a suffix that is none of a log; "" where nobody knows."""
    return next((fix for fix, suffixes in _SUFFIXES.items() if suffix.lower() in suffixes.split()), "")
