"""Keep today's figures from now on, and write down why.

python -m tests.tuning.renew --reason WHY [--rig-folder PATH] [RECORDING ...]
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from estimator.errors import BallscrewError, SetupError

from .compare import better, digits, table, worse
from .kept import Kept, kept_path, read, write
from .measure import PAPER, Folder, fingerprint

FIRST = ("FS-20.blf", "CS-10.blf", "ES-20.blf")  # of the paper's rig: the committed ones


def renew(path: Path, reason: str, recordings: Sequence[str] = ()) -> str:
    """Measure a rig folder anew, write its kept.toml and say what changed.

    recordings  as seen from the folder; by default those kept so far, at first all of the folder
    """
    if not reason.strip():
        raise SetupError('say why the figures are renewed: REASON="why", or --reason WHY')
    folder, file = Folder(path), kept_path(path)
    before = read(file) if file.is_file() else Kept()
    names = list(recordings) or before.recordings or (list(FIRST) if path.resolve() == PAPER else folder.names())
    figures, model = folder.figures(names), fingerprint(folder.model)
    now = {key: float(digits(value)) for key, value in figures.items()}
    if (before.model, before.recordings, before.figures) == (model, names, now):
        return f"{file}: nothing changed; left as it is"
    lost, won = worse(before.figures, now, before.tolerance), better(before.figures, now, before.tolerance)
    entry = {"why": reason.strip(), "model": model, "better": len(won), "worse": len(lost)}
    write(file, Kept(model, names, before.tolerance, [*before.reasons, entry], now))
    tables = [f"{title}\n{table(some)}\n" for title, some in (("worse", lost), ("better", won)) if some]
    new, same = len(now.keys() - before.figures.keys()), sum(before.figures.get(key) == now[key] for key in now)
    rest = f"{same} as before, {new} new, the others within their tolerance"
    return "\n".join([*tables, f"{file}: {len(now)} figures: {len(lost)} worse, {len(won)} better, {rest}"])


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line above; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.tuning.renew", description="Keep today's figures.")
    parser.add_argument("--reason", required=True, help="why; written into kept.toml")
    parser.add_argument("--rig-folder", type=Path, default=PAPER, metavar="PATH", help="default: the paper's rig")
    parser.add_argument("recordings", nargs="*", metavar="RECORDING", help="seen from the folder; default: as before")
    asked = parser.parse_args(arguments)
    try:
        print(renew(asked.rig_folder, asked.reason, asked.recordings))
    except BallscrewError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main())
