"""A rig folder as commands find it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from estimator.rig_folder.model_toml import load_model
from tests.conftest import PAPER

FREE = {"nut_friction.power", "anchor_friction.power"}


@pytest.fixture
def rig_folder(fs20_log, tmp_path) -> Path:
    """A rig folder: rig, model with two free parameters, and FS-20 with its truth in a folder below."""
    shutil.copy(PAPER / "rig.toml", tmp_path)
    model = load_model(PAPER / "model.toml")
    lines = [
        f'[{name}]\n' + "".join(
            f"{key} = {{value = {model[path]}, fixed = {str(path not in FREE).lower()}}}\n"
            for key, path in ((key, f"{name}.{key}") for key in effect.params)
        )
        for name, effect in model.effects.items()
    ]  # fmt: skip
    (tmp_path / "model.toml").write_text("\n".join(lines))
    (tmp_path / "logs").mkdir()
    for path in (fs20_log, fs20_log.with_name("FS-20.truth.csv")):
        shutil.copy(path, tmp_path / "logs")
    return tmp_path
