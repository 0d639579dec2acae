"""Review says of each recording whether it begins with a cold screw."""

from pathlib import Path

import pytest

from tests.conftest import ended, json_of


@pytest.fixture
def warm_log(tmp_path, fs20_log) -> Path:
    """The log without its first 200 s: it begins in the drive."""
    lines = fs20_log.read_text().splitlines(keepends=True)
    first = float(lines[0][1:].partition(")")[0])
    path = tmp_path / "warm.log"
    path.write_text("".join(line for line in lines if float(line[1:].partition(")")[0]) > first + 200.0))
    return path


def test_a_warm_start_is_said_and_a_cold_one_is_not(warm_log, fs20_log):
    out, _ = ended(0, "review", warm_log, fs20_log)
    assert "warm.log began warm: about 4" in out
    assert "FS-20.log began warm" not in out
    warm, cold = (one["start"] for one in json_of("review", warm_log, fs20_log)["recordings"])
    assert warm["warm"]
    assert not cold["warm"]
    assert set(warm) == {"warm", "grown_um", "sd_um"}
    assert abs(cold["grown_um"]) < cold["sd_um"] < 3.0
