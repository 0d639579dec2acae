"""What `review --table` writes beside recordings: never a recording."""

from pathlib import Path

_BEGINS = ('"time_s","mode","elongation_um"', '"recording","time_s","mode"')


def is_estimates(path: Path) -> bool:
    """Whether a CSV is by its first columns a table of estimates."""
    if path.suffix.lower() != ".csv" or not path.is_file():
        return False
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            return file.read(64).startswith(_BEGINS)
    except OSError:
        return False  # reading it says what is wrong with it
