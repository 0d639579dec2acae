"""Which recording a monitor that is started again goes on with: the one that has just ended, of this rig and bus."""

from pathlib import Path

import pytest

from drivers.received import Received
from drivers.recorder.earlier import earlier, frames_of
from drivers.recorder.recorder import Recorder

START = 1_700_000_000.0
ABOUT = {"rig": "screw", "bus": "can0", "model": "model.toml", "speed_up": 1.0}


def recorded(folder: Path, first_s: float, last_s: float, **about: object) -> Path:
    """A part with a frame every second, and what it is called."""
    with Recorder(folder, {**ABOUT, **about}) as recorder:
        for k in range(int(last_s - first_s) + 1):
            recorder.write(Received(START + first_s + k, 0x210, False, bytes([k % 256])))
        return recorder.path


@pytest.mark.parametrize(
    ("after_s", "found"), [(1.0, True), (3500.0, True), (3700.0, False), (-30.0, True), (-90.0, False)]
)
def test_it_ended_less_than_an_hour_ago(tmp_path, after_s, found):
    path = recorded(tmp_path, 0.0, 50.0)
    assert earlier(tmp_path, ABOUT, START + 50.0 + after_s) == ([path] if found else [])


def test_its_parts_follow_each_other_by_less_than_an_hour(tmp_path):
    recorded(tmp_path, 0.0, 50.0)
    second, third = recorded(tmp_path, 4000.0, 4050.0), recorded(tmp_path, 5000.0, 5010.0)
    assert earlier(tmp_path, ABOUT, START + 5100.0) == [second, third]


@pytest.mark.parametrize("other", [{"rig": "rod"}, {"bus": "can1"}, {"speed_up": 60.0}])
def test_what_is_of_another_rig_or_bus_is_not_it(tmp_path, other):
    first = recorded(tmp_path, 0.0, 50.0)
    recorded(tmp_path, 60.0, 70.0, **other)
    assert earlier(tmp_path, ABOUT, START + 80.0) == [first]


def test_what_nobody_recorded_or_what_is_broken_is_not_it(tmp_path):
    path = recorded(tmp_path, 0.0, 50.0)
    (tmp_path / "copied.log").write_text(f"({START + 60:.6f}) can0 210#00\n")
    (tmp_path / "torn.log").write_text("(1700")
    (tmp_path / "torn.json").write_text("{")
    (tmp_path / "odd.log").write_text(f"({START + 60:.6f}) can0 210#00\n")
    (tmp_path / "odd.json").write_text("[]")
    assert earlier(tmp_path, ABOUT, START + 70.0) == [path]
    assert earlier(tmp_path / "none", ABOUT, START) == []


def test_one_that_was_killed_is_read_to_its_last_whole_line(tmp_path):
    path = recorded(tmp_path, 0.0, 50.0)
    path.write_bytes(path.read_bytes()[:-5])
    assert earlier(tmp_path, ABOUT, START + 3645.0) == [path]
    assert earlier(tmp_path, ABOUT, START + 3649.5) == []


def test_its_frames_come_as_they_were(tmp_path):
    recorded(tmp_path, 0.0, 50.0)
    recorded(tmp_path, 60.0, 70.0)
    frames = list(frames_of(earlier(tmp_path, ABOUT, START + 80.0)))
    assert [frame.time_s - START for frame in frames] == [*range(51), *range(60, 71)]
    assert frames[3]._replace(dlc=0) == Received(START + 3.0, 0x210, False, b"\x03")
    assert list(frames_of([tmp_path / "none.log"])) == []
