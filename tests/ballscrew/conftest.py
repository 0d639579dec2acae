"""A rig folder as commands find it."""

import shutil
from pathlib import Path

import pytest

from estimator.rig_folder.model_toml import load_model
from tests.conftest import PAPER

FREE = {"nut_friction.power", "anchor_friction.power"}


@pytest.fixture(scope="session")
def short_log(fs20_log, tmp_path_factory) -> Path:
    """The first two minutes of FS-20, a drive, without its truth: for what does not hang on the numbers."""
    path = tmp_path_factory.mktemp("short") / "FS-20.log"
    lines = fs20_log.read_text().splitlines(keepends=True)
    first = float(lines[0][1:].partition(")")[0])
    path.write_text("".join(line for line in lines if float(line[1:].partition(")")[0]) < first + 120.0))
    return path


@pytest.fixture
def rig_folder(fs20_log, tmp_path) -> Path:
    """A rig folder: rig, model with two free parameters, and FS-20 with its truth in a folder below."""
    return folder_of(fs20_log, fs20_log, tmp_path)


@pytest.fixture
def short_folder(short_log, fs20_log, tmp_path) -> Path:
    """The same with two minutes of it."""
    return folder_of(short_log, fs20_log, tmp_path)


def folder_of(log: Path, whole: Path, path: Path) -> Path:
    """The same with any part of it, and the truth of the whole."""
    shutil.copy(PAPER / "rig.toml", path)
    model = load_model(PAPER / "model.toml")
    lines = [
        f'[{name}]\n' + "".join(
            f"{key} = {{value = {model[path]}, fixed = {str(path not in FREE).lower()}}}\n"
            for key, path in ((key, f"{name}.{key}") for key in effect.params)
        )
        for name, effect in model.effects.items()
    ]  # fmt: skip
    (path / "model.toml").write_text("\n".join(lines))
    (path / "logs").mkdir()
    for each in (log, whole.with_name("FS-20.truth.csv")):
        shutil.copy(each, path / "logs")
    return path


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports with one picture that shows nothing: true ones take longer than all else."""

    def blank(stem: Path, *_: object) -> dict[str, Path]:
        picture = stem.with_name(f"{stem.name}-steps.png")
        picture.write_bytes(b"nothing")
        return {"steps": picture}

    monkeypatch.setattr("ballscrew.report.comparison_views.write_pictures", blank)


@pytest.fixture
def unfelt(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody asks what the axis feels, which takes two replays and two runs without readings."""
    monkeypatch.setattr("ballscrew.commands.improve.at_the_table", lambda *_: [])
