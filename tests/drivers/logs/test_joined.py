"""Logs that are parts of one recording are read as if they had never been cut."""

from pathlib import Path

import numpy as np
import pytest

from drivers.budget import Budget
from drivers.received import Received
from drivers.recorder.recorder import Recorder
from drivers.recordings import find_recordings, read_joined, read_recording
from estimator.errors import InputError
from tests import log_fake
from tests.conftest import json_of
from tests.drivers.decode.test_ticks import RIG, assert_same

ROWS = log_fake.log(40, 10, (3, 30))


def cut(folder: Path, names: str, rows: list[log_fake.Row] = ROWS) -> list[Path]:
    """The rows in as many files of about one length, by the first letters of their names."""
    folder.mkdir(exist_ok=True)
    edges = [round(k * len(rows) / len(names)) for k in range(len(names) + 1)]
    return [
        log_fake.write(folder / f"{name}.log", rows[begin:end])
        for name, begin, end in zip(names, edges, edges[1:], strict=False)
    ]


@pytest.fixture
def whole(tmp_path: Path):
    return read_recording(log_fake.write(tmp_path / "whole.log", ROWS), RIG)


def test_parts_are_read_as_one_in_the_order_of_their_first_frames(tmp_path: Path, whole) -> None:
    shares: list[float] = []
    paths = cut(tmp_path / "parts", "cab")
    first, record = read_joined(sorted(paths), RIG, shares.append)
    assert_same(record, whole)
    assert record.name == "c.log.."
    assert first == paths[0]
    assert record.frames == len(ROWS)
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)


def test_a_recorder_s_folder_is_one_recording(tmp_path: Path, whole) -> None:
    with Recorder(tmp_path / "runs", {}, size_bytes=5000) as recorder:
        for row in ROWS:
            recorder.write(Received(*row))
    paths = find_recordings([tmp_path / "runs"])
    assert len(paths) > 3
    assert_same(read_joined(paths, RIG)[1], whole)


def test_what_is_said_of_a_part_names_it(tmp_path: Path) -> None:
    paths = cut(tmp_path / "parts", "abc")
    text = paths[1].read_text()
    paths[1].write_text(text + "(1700000020.0) can0 21")
    late = [row._replace(time=row.time + 30) for row in ROWS[2 * len(ROWS) // 3 :]]
    log_fake.write(paths[2], late)
    (tmp_path / "parts" / "d.log").write_text("")
    _, record = read_joined([*paths, tmp_path / "parts" / "d.log"], RIG)
    torn = text.count("\n") + 1
    assert f"b.log: torn at line {torn}: it has no line end; read up to there" in record.notes
    assert any(note.startswith(f"left out: {tmp_path / 'parts' / 'd.log'}: 0 usable frames") for note in record.notes)
    assert any("(c.log line 1)" in note for note in record.notes), record.notes
    assert record.skipped["torn line"] == 1


def test_a_gap_between_parts_is_a_gap_in_time(tmp_path: Path, whole) -> None:
    paths = cut(tmp_path / "parts", "abcd")
    _, record = read_joined([paths[0], paths[1], paths[3]], RIG)
    assert len(record) == pytest.approx(len(whole), abs=1)
    assert record.time_s[-1] == pytest.approx(whole.time_s[-1], abs=1e-3)
    assert np.isnan(record.channels).all(axis=1).sum() > 5


def test_too_much_is_not_read(tmp_path: Path) -> None:
    paths = cut(tmp_path / "parts", "abc")
    _, record = read_joined(paths, RIG, budget=Budget(frames=len(ROWS) // 2))
    assert record.notes[-1].startswith(f"c.log and what follows is not read: {len(ROWS) // 2} frames are the most")
    assert record.frames == pytest.approx(2 * len(ROWS) / 3, abs=1)


def test_what_cannot_be_joined(tmp_path: Path) -> None:
    (tmp_path / "lab.csv").write_text("time,T1\n0,20\n1,21\n")
    with pytest.raises(InputError, match=r"lab\.csv: a lab CSV cannot be joined"):
        read_joined([*cut(tmp_path / "parts", "a"), tmp_path / "lab.csv"], RIG)
    for name in ("x.log", "y.log"):
        (tmp_path / name).write_text("")
    with pytest.raises(InputError, match=r"x\.log: 0 usable frames .*y\.log: 0 usable frames"):
        read_joined([tmp_path / "x.log", tmp_path / "y.log"], RIG)


def test_review_runs_one_estimate_through_the_parts(tmp_path: Path, fs20_log: Path) -> None:
    lines = fs20_log.read_text().splitlines(keepends=True)
    for name, part in (("b.log", lines[: len(lines) // 3]), ("a.log", lines[len(lines) // 3 :])):
        (tmp_path / name).write_text("".join(part))
    (tmp_path / "b.truth.csv").write_bytes(fs20_log.with_name("FS-20.truth.csv").read_bytes())
    (joined,) = json_of("review", "--join", tmp_path)["recordings"]
    (whole,) = json_of("review", fs20_log)["recordings"]
    assert joined.pop("name") == "b.log.."
    whole.pop("name")
    for key in ("seconds", "took_s"):
        joined.pop(key, None), whole.pop(key, None)
    assert joined == whole
    assert [one["name"] for one in json_of("review", "--join", tmp_path / "a.log")["recordings"]] == ["a.log"]
