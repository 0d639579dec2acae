"""Keeping figures: of an own rig folder, with a reason, in a file that reads back the same."""

import re
import shutil
from pathlib import Path

import pytest

from estimator.errors import SetupError
from estimator.rig_folder.model_toml import load_model, save_model
from tests.conftest import ROD
from tests.processes import ended

from .kept import Kept, kept_path, read, write
from .measure import PAPER, Folder, fingerprint
from .renew import FIRST, main


@pytest.fixture(scope="module")
def rod(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A rig folder of one's own, its figures kept: no truth, no displacement, one of two recordings fitted."""
    path = shutil.copytree(
        ROD,
        tmp_path_factory.mktemp("own") / "rod",
        ignore=shutil.ignore_patterns("kept.toml", "pulses.csv", "slow.csv"),
    )
    assert main(["--rig-folder", str(path), "--reason", 'the "first" figures']) == 0
    return path


def scale(folder: Path, path: str, factor: float) -> None:
    """Multiply a value of the folder's model."""
    model = load_model(folder / "model.toml")
    save_model(model.with_values({path: factor * model[path]}), folder / "model.toml")


def test_an_own_folder_has_its_own_figures(rod: Path) -> None:
    kept = read(rod / "kept.toml")
    assert kept.recordings == ["check.csv", "steps.csv"]
    assert kept.reasons == [
        {"why": 'the "first" figures', "model": fingerprint(Folder(rod).model), "better": 0, "worse": 0}
    ]
    errors = [key for key in kept.figures if key[2].endswith(("_K", "_um"))]
    assert {(key[0], key[1]) for key in errors} == {("check.csv", "thermometers")}
    assert ("steps.csv", "TC8", "nis") in kept.figures


def test_the_tests_judge_an_own_folder(rod: Path, tmp_path: Path) -> None:
    folder, here = shutil.copytree(rod, tmp_path / "rod"), Path(__file__).parent
    scale(folder, "heater.share", 0.99)
    words = ["-m", "pytest", here / "test_tuning.py", "--rig-folder", folder, "-p", "no:cacheprovider"]
    found = ended(*words, cwd=here.parents[1])
    assert found.returncode == 1
    assert "FAILED tests/tuning/test_tuning.py::test_no_worse_than_kept[check.csv]" in found.stdout
    assert re.search(r"\nopen_loop_K +check.csv +thermometers +0.05\d+ +0.\d+ +5%\n", found.stdout)
    assert "model: changed; if it is meant: make tuning" in found.stdout


def test_no_kept_figures_are_said(tmp_path: Path) -> None:
    with pytest.raises(SetupError, match="no figures kept yet; make tuning REASON"):
        read(tmp_path / "kept.toml")


def test_a_renewal_says_what_changed_and_keeps_the_reasons(
    rod: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = shutil.copytree(rod, tmp_path / "rod")
    assert main(["--rig-folder", str(folder), "--reason", "again"]) == 0
    assert "nothing changed" in capsys.readouterr().out
    scale(folder, "thermometers.sd", 0.5)
    assert main(["--rig-folder", str(folder), "--reason", "quieter thermocouples"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("worse\nfigure ")
    kept = read(folder / "kept.toml")
    assert [reason["why"] for reason in kept.reasons] == ['the "first" figures', "quieter thermocouples"]
    assert kept.reasons[-1]["worse"] > 0
    assert f"{kept.reasons[-1]['worse']} worse" in out


def test_without_a_reason_nothing_is_kept(rod: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (rod / "kept.toml").read_text()
    assert main(["--rig-folder", str(rod), "--reason", "  "]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert (rod / "kept.toml").read_text() == before


def test_the_file_reads_back_the_same(tmp_path: Path) -> None:
    figures = {("a b.log", "T 1", "nis"): 1.0, ("a b.log", "T 1", "in_2sd"): 0.95, ("c.log", "all", "nis"): 12345.0}
    reasons: list[dict[str, str | int]] = [{"why": 'new "nut"\\', "model": "0" * 12, "better": 1, "worse": 0}]
    kept = Kept("f" * 12, ["a b.log", "c.log"], {"all": {"nis": 0.5}, "channel": {}}, reasons, figures)
    write(tmp_path / "kept.toml", kept)
    back = read(tmp_path / "kept.toml")
    assert back == Kept(
        kept.model, kept.recordings, kept.tolerance, reasons, {**figures, ("c.log", "all", "nis"): 12340.0}
    )


def test_the_paper_s_figures_are_of_the_committed_recordings() -> None:
    assert read(kept_path(PAPER)).recordings == list(FIRST)
