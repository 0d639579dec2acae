"""Dialects of Vector's .asc."""

from pathlib import Path

import numpy as np
import pytest

from drivers.frames import Tally
from drivers.logs.every_frame import every_frame
from drivers.recordings import read_recording
from estimator.errors import InputError
from tests import log_fake
from tests.conftest import RIG

ROWS = log_fake.log(30, moves=(20, 25))
DATE = "Tue Nov 14 10:13:20.000 pm 2023"


def asc(path: Path, times: np.ndarray, kind: str, date: str = DATE, between: str = "") -> Path:
    head = [f"date {date}", f"base hex  timestamps {kind}", "internal events logged", f"Begin Triggerblock {date}"]
    frames = [
        f"{time:11.6f} 1  {row.id:X}             Rx   d {len(row.data)} {row.data.hex(' ').upper()}\n{between}"
        for time, row in zip(times, ROWS)
    ]
    path.write_text("\n".join([*head, "".join(frames)]) + "End TriggerBlock\n")
    return path


@pytest.fixture
def since() -> np.ndarray:
    """Times of the frames since the first, s."""
    return np.array([row.time for row in ROWS]) - ROWS[0].time


def assert_as_written(path: Path, other: Path) -> None:
    record, same = read_recording(path, RIG), read_recording(log_fake.write(other, ROWS), RIG)
    np.testing.assert_allclose(record.time_s, same.time_s, atol=1e-4)
    np.testing.assert_array_equal(record.channels, same.channels)


@pytest.mark.parametrize("date", [DATE, "yesterday"])
def test_times_relative_to_the_line_before(tmp_path: Path, since: np.ndarray, date: str) -> None:
    path = asc(tmp_path / "a.asc", np.diff(since, prepend=0.0), "relative", date)
    assert_as_written(path, tmp_path / "b.log")


def test_lines_without_a_frame_take_time_too(tmp_path: Path, since: np.ndarray) -> None:
    steps = np.round(np.diff(since, prepend=0.0) / 2, 7)
    event = "%s 1  Statistic: D 0 R 0 XD 0 XR 0 E 0 O 0 B 0.00%%\n"
    path = asc(tmp_path / "a.asc", steps, "relative", between="@\n")
    text = path.read_text()
    for step in [*steps[1:], 0.0]:
        text = text.replace("@\n", event % f"{step:.6f}", 1)
    path.write_text(text)
    assert_as_written(path, tmp_path / "b.log")


@pytest.mark.parametrize("date", [DATE, "yesterday"])
@pytest.mark.parametrize("before_s", [0.5, 8.0])
def test_times_before_the_trigger(tmp_path: Path, since: np.ndarray, before_s: float, date: str) -> None:
    assert_as_written(asc(tmp_path / "a.asc", since - before_s, "absolute", date), tmp_path / "b.log")


def test_a_head_that_says_relative_of_times_that_only_rise(tmp_path: Path, since: np.ndarray) -> None:
    path = asc(tmp_path / "a.asc", since, "relative")
    assert_as_written(path, tmp_path / "b.log")
    assert "its times only rise" in read_recording(path, RIG).notes[0]
    path.write_text(path.read_text().replace("timestamps relative", "timestamps absolute"))
    assert_as_written(path, tmp_path / "b.log")


def test_times_that_go_up_and_down_below_a_head_that_says_absolute(tmp_path: Path, since: np.ndarray) -> None:
    path = asc(tmp_path / "a.asc", np.diff(since, prepend=0.0), "absolute")
    assert_as_written(path, tmp_path / "b.log")
    assert "times go up and down: taken as counting from the line before" in read_recording(path, RIG).notes[0]


@pytest.mark.parametrize("lines", [1, 2, 3, 4])
def test_a_head_that_is_not_whole_costs_no_frame(tmp_path: Path, since: np.ndarray, lines: int) -> None:
    path = asc(tmp_path / "a.asc", since, "absolute")
    path.write_text("".join(path.read_text().splitlines(keepends=True)[lines:]))
    assert_as_written(path, tmp_path / "b.log")
    assert read_recording(path, RIG).frames == len(ROWS)


@pytest.mark.parametrize("suffix", [".log", ".asc", ".trc"])
def test_utf_16_is_refused_with_what_converts_it(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_text(log_fake.text(ROWS), encoding="utf-16")
    with pytest.raises(InputError, match="is UTF-16 text; convert it: iconv -f UTF-16 -t UTF-8"):
        read_recording(path, RIG)


def test_blanks_before_and_between_what_a_candump_line_says(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    path.write_text("".join(f"  {line}\n" for line in log_fake.text(ROWS).replace(") ", ")   ").splitlines()))
    assert_as_written(path, tmp_path / "b.log")
    assert len(list(every_frame(path, Tally()))) == len(ROWS)


@pytest.mark.parametrize("name", ["", "Telemeter "])
def test_classic_frames_on_lines_of_can_fd(tmp_path: Path, since: np.ndarray, name: str) -> None:
    def line(time: float, row: log_fake.Row, flags: int) -> str:
        data = row.data.hex(" ").upper()
        return f"{time:11.6f} CANFD   1 Rx {row.id:>10X} {name} 0 0 {len(row.data):x} {len(row.data):2} {data} 1000  125 {flags:8x} 0 0 0 0 0\n"  # noqa: E501

    path = tmp_path / "a.asc"
    head = f"date {DATE}\nbase hex  timestamps absolute\ninternal events logged\nBegin Triggerblock {DATE}\n"
    path.write_text(
        head + "".join(line(time, row, 0x200000) for time, row in zip(since, ROWS)) + line(99.0, ROWS[0], 0x1000)
    )
    assert_as_written(path, tmp_path / "b.log")
    assert read_recording(path, RIG).skipped["CAN FD frame"] == 1
