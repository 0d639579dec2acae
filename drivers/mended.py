"""A plant's DBC without what cannot be read in it: one broken message of sixty is no reason to read none."""

import codecs
import logging
import re
from collections import Counter
from pathlib import Path
from typing import Any

_KINDS = ("dbc", "arxml", "kcd", "sym", "cdd")  # as cantools calls them
_MOST = 300  # parts left out: each is another reading of the file
_KEYWORD = re.compile(r"[A-Z][A-Z_]*_?\b")  # at the beginning of a line, where a part of a DBC begins
_MESSAGE = re.compile(r"BO_ +(\d+) +([^:]*)")


def read_dbc(path: Path) -> tuple[list[Any], dict[str, str]]:
    """The messages of a DBC, by cantools, and what is not read and why, by message or first words.

    One that is none is a ValueError. Of messages of one name none is to be used.
    """
    from drivers.canbus import cantools

    logging.getLogger("cantools").setLevel(logging.ERROR)  # it would print what is there twice
    kind = path.suffix.lower().removeprefix(".")
    if kind not in _KINDS:
        raise ValueError(f"no file of messages by its suffix; expected .{', .'.join(_KINDS)}")
    lines, left_out = _text(path).splitlines(keepends=True), dict[str, str]()
    if kind == "dbc" and not any(line.lstrip().startswith(("BO_", "VERSION")) for line in lines):
        raise ValueError(f"no line begins with BO_, where a message does; it begins with '{_beginning(lines)}'")
    while True:
        try:
            messages = cantools.database.load_string("".join(lines), kind, strict=False).messages
            break
        except cantools.Error as error:
            why = " ".join(str(error).split())
            part = _part(lines, why)
            if part is None or len(left_out) > _MOST:
                raise ValueError(why) from None
            message = _MESSAGE.match(lines[part.start])
            left_out[message[2].strip() if message else lines[part.start].strip()[:40]] = why
            del lines[part]
    count = Counter(message.name for message in messages)
    return messages, left_out | {name: "two messages have this name" for name in count if count[name] > 1}


def _beginning(lines: list[str]) -> str:
    return next((line.strip() for line in lines if line.strip()), "")[:40]


def _text(path: Path) -> str:
    text = path.read_bytes()
    if text.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return text.decode("utf-16", "replace")
    try:
        return text.decode("utf-8-sig")
    except UnicodeDecodeError:
        return text.decode("cp1252", "replace")


def _part(lines: list[str], why: str) -> slice | None:
    """The lines of the part that an error is about; None where it does not say."""
    if at := re.search(r"at line (\d+)", why):
        first = int(at[1]) - 1
    elif named := re.search(r"in message (\w+)", why):
        pattern = re.compile(rf"BO_ +\d+ +{named[1]} *:")
        first = next((k for k, line in enumerate(lines) if pattern.match(line)), -1)
    elif unused := re.search(r"unused \S+ entries in DBC: (\S+ \d+ \w+)", why):
        first = next((k for k, line in enumerate(lines) if " ".join(line.split()).startswith(unused[1])), -1)
    else:
        return None
    while 0 < first < len(lines) and not _KEYWORD.match(lines[first]):
        first -= 1
    if not 0 <= first < len(lines):
        return None
    last = first + 1
    while last < len(lines) and not _KEYWORD.match(lines[last]):
        last += 1
    return slice(first, last)
