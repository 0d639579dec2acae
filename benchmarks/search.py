"""How long it takes to be told which effect is missing, and to have two added: six recordings, as commands."""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks import paper_rig
from benchmarks.measure import Row, say, table
from estimator.rig_folder.model_toml import save_model

SIX = ("FS-20", "FS-10", "FS-5", "CS-10", "CS-5", "ES-5")
ONE, TWO = ("rotating_convection",), ("rotating_convection", "free_housing")


@contextmanager
def without(names: tuple[str, ...]) -> Iterator[Path]:
    """A folder with the model that lacks these effects, model.toml."""
    model = paper_rig.model("base")
    for name in names:
        model = model - name
    with tempfile.TemporaryDirectory() as folder:
        save_model(model, Path(folder) / "model.toml")
        yield Path(folder)


def told(folder: Path, command: str, *options: str) -> tuple[float, dict[str, Any]]:
    """Seconds that a command takes on the six recordings, start included, and what it says."""
    logs = [str(paper_rig.path_of(name)) for name in SIX]
    words = ["--rig", str(paper_rig.FOLDER), "--model", str(folder / "model.toml"), "--json", str(folder / "said.json")]
    began = time.perf_counter()
    line = [sys.executable, "-m", "ballscrew", command, *logs, *words, "--quiet", *options]
    subprocess.run(line, check=True, cwd=folder)
    return time.perf_counter() - began, json.loads((folder / "said.json").read_text())


def markdown() -> str:
    """Measure both; the table."""
    say("suggest")
    with without(ONE) as folder:
        suggest_s, suggested = told(folder, "suggest")
    say("improve")
    with without(TWO) as folder:
        improve_s, improved = told(folder, "improve", "-o", str(folder / "better.toml"))
    first = [effect["name"] for effect in suggested["effects"][:1]]
    added = [step["added"] for step in improved["steps"] if step["added"]]
    rows = [
        Row(f"suggest, without {ONE[0]}", f"{suggest_s:.0f} s: {suggested['verdict']}, {first[0]}", suggest_s, 90.0),
        Row(f"improve, without {' and '.join(TWO)}", f"{improve_s:.0f} s: + {', + '.join(added)}", improve_s, 360.0),
    ]
    says = [
        f"base.toml without what is to be found, on {', '.join(SIX)}; start, compiled code, report and views included."
    ]
    return table("The search for a missing effect: six recordings, as commands", rows, says)
