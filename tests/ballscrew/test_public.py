"""The public face: its names, each there, none loaded before it is used; and the example of the README runs."""

import re
import shutil
import subprocess
import sys
from importlib.metadata import version

import matplotlib.image
import matplotlib.pyplot as plt
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import ballscrew
from estimator.work import one_thread
from tests.conftest import PAPER

NAMES = {
    "CATALOGUE", "Effect", "Filter", "Param", "Runs", "compare", "diagnose", "events", "fit", "improve", "load_model",
    "load_rig", "read", "review", "suggest", "tune",
}  # fmt: skip


def test_the_public_names_are_these_and_each_is_there():
    assert set(ballscrew.__all__) == {*NAMES, "__version__"}
    assert set(dir(ballscrew)) >= NAMES
    for name in NAMES:
        assert getattr(ballscrew, name).__doc__ or name == "CATALOGUE"
    assert ballscrew.__version__ == version("ballscrew")
    with pytest.raises(AttributeError, match="has no attribute 'fits'"):
        _ = ballscrew.fits


def test_small_matrices_are_computed_by_one_thread_and_the_process_has_its_own_number_again():
    for name in ("compare", "diagnose", "events", "fit", "improve", "review", "suggest", "tune"):
        assert hasattr(getattr(ballscrew, name), "__wrapped__")
    assert hasattr(ballscrew.Filter.step, "__wrapped__")
    libraries = len(one_thread(threads)())
    with threadpool_limits(2, "blas"):
        assert one_thread(threads)() == [1] * libraries
        assert threads() == [2] * libraries


def threads() -> list[int]:
    return [one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"]


def test_to_import_it_is_to_load_nothing():
    program = "import sys, ballscrew; print(*sorted({m.partition('.')[0] for m in sys.modules} & set(sys.argv)))"
    heavy = ["numpy", "numba", "click", "rich", "estimator", "drivers", "viz"]
    done = subprocess.run([sys.executable, "-c", program, *heavy], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_the_example_of_the_readme_draws_what_it_says(fs20_log, tmp_path, monkeypatch):
    (code,) = re.findall(r"## From Python\n\n```python\n(.*?)```", (PAPER.parent / "README.md").read_text(), re.DOTALL)
    assert len(re.findall(r"\n", code)) <= 12
    (tmp_path / "recordings").mkdir()
    for name in ("rig.toml", "model.toml"):
        shutil.copy(PAPER / name, tmp_path / "recordings")
    shutil.copy(fs20_log, tmp_path)
    monkeypatch.chdir(tmp_path)
    plt.switch_backend("Agg")
    exec(code, {})
    plt.close()
    drawn = matplotlib.image.imread(tmp_path / "elongation.png")[:, :, :3]
    colours = {tuple(pixel) for pixel in (drawn.reshape(-1, 3) * 255).round().astype(int).tolist()}
    assert {(31, 119, 180), (255, 127, 14)} <= colours  # the estimate and the reference
