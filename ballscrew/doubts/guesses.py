"""Lines of a rig.toml that `ballscrew init` has guessed, and that nobody has looked at yet."""

from pathlib import Path

GUESSED = "# guessed:"


def guesses(folder: Path) -> list[int]:
    """Their numbers in the file."""
    lines = (folder / "rig.toml").read_text(encoding="utf-8-sig").splitlines()
    return [k for k, line in enumerate(lines, start=1) if GUESSED in line]
