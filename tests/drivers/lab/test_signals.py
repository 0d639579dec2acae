"""An MF4 of decoded signals is the recording that its numbers are as a CSV."""

import gc
from pathlib import Path

import numpy as np
import pytest

from drivers.recordings import read_recording
from estimator.errors import InputError
from estimator.rig import Rig
from tests.drivers.lab.conftest import NAMES, ROWS, rows, write


def mf4(path: Path, names: dict[str, str], apart_s: float = 0.0) -> Path:
    """The rows of the CSVs, each column a signal of its own group, in its unit, `apart_s` after the one before."""
    asammdf = pytest.importorskip("asammdf")  # late: it takes most of a second
    table = np.array(rows(), dtype=float)
    with asammdf.MDF(version="4.10") as mdf:
        for k, (name, unit) in enumerate(names.items(), start=1):
            mdf.append([asammdf.Signal(table[:, k], table[:, 0] + k * apart_s, name=name, unit=unit)])
        mdf.save(str(path), overwrite=True)
    return path


@pytest.mark.parametrize("apart_s", [0.0, 0.01])
def test_signals_are_read_by_their_names(tmp_path: Path, rig: Rig, apart_s: float) -> None:
    names = dict(zip(NAMES[1:], ["degC", "", "kW", "degC"], strict=True))
    record = read_recording(mf4(tmp_path / "a.mf4", names, apart_s), rig)
    plain = read_recording(write(tmp_path / "plain.csv", rows()), rig)
    np.testing.assert_allclose(record.channels, plain.channels[: len(record)])
    np.testing.assert_allclose(record.inputs["heater"], plain.inputs["heater"][: len(record)])
    assert len(record) >= ROWS - 1
    assert "signals by their names" in record.notes[0]


def test_signals_that_are_others_are_told(tmp_path: Path, rig: Rig) -> None:
    names = dict.fromkeys(["left", "B2"], "degC")
    assert "no signal B, P/kW, ambient: not measured" in read_recording(mf4(tmp_path / "a.mf4", names), rig).notes
    with pytest.raises(InputError, match=r"column 'left' is in degF, rig\.toml has A in degC"):
        read_recording(mf4(tmp_path / "b.mf4", {"left": "°F"}), rig)
    with pytest.raises(InputError, match="no signal of any channel; expected left, B, found x, y"):
        read_recording(mf4(tmp_path / "c.mf4", {"x": "", "y": ""}), rig)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # asammdf's own, as it clears away
def test_a_torn_file_is_refused(tmp_path: Path, rig: Rig) -> None:
    torn = mf4(tmp_path / "d.mf4", {"left": "degC"})
    torn.write_bytes(torn.read_bytes()[:2000])
    with pytest.raises(InputError, match=r"d\.mf4: cannot be read as MF4: "):
        read_recording(torn, rig)
    gc.collect()
