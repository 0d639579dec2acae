"""Export: every frame comes back from every format, as far as the format holds it; and what is said of the rest."""

import json
import random
from importlib.util import find_spec
from pathlib import Path
from unittest import mock

import can
import pytest

from drivers.budget import Budget
from drivers.frames import Tally
from drivers.logs.candump_line import line_of
from drivers.logs.every_frame import every_frame
from drivers.received import Received
from drivers.recordings import read_recording
from tests import log_fake
from tests.conftest import RIG, ballscrew as run, ended
from tests.drivers.logs.test_outside import endless

START = 1_700_000_000.005  # python-can's ASC writer would make half a second of these 5 ms
SUFFIXES = [".log", ".blf", ".asc", ".trc"]
SUFFIXES += [".mf4"] * (find_spec("asammdf") is not None)


def frames(count: int, seed: int = 1, channels: str = "00001") -> list[Received]:
    """Frames of every kind on two channels, some with the same time."""
    draw = random.Random(seed)
    time_us, rows = round(START * 1e6), []
    for _ in range(count):
        kind = draw.choices(["data", "remote", "error", "fd"], [20, 1, 1, 1])[0]
        extended = kind == "error" or draw.random() < 0.5
        data = draw.randbytes({"data": draw.randrange(9), "remote": 0, "error": 8}.get(kind, draw.choice([1, 12, 64])))
        rows.append(
            Received(
                time_us / 1e6, draw.randrange(1 << (29 if extended else 11)), extended, data, kind,
                f"can{draw.choice(channels)}", draw.randrange(9) if kind == "remote" else len(data),
                draw.randrange(4) if kind == "fd" else 0,
            )
        )  # fmt: skip
        time_us += draw.choice([0, 1, 137, 9_999, 1_000_003])
    return rows


def log(path: Path, rows: list[Received]) -> Path:
    path.write_text("".join(map(line_of, rows)))
    return path


def read(path: Path) -> list[Received]:
    return list(every_frame(path, Tally()))


def held(rows: list[Received], suffix: str) -> list[Received]:
    """What a format can hold of these frames."""
    if suffix == ".trc":
        return [row for row in rows if row.kind == "data"]
    if suffix == ".asc":
        bare = {"id": 0, "data": b"", "dlc": 0, "extended": True}
        return [row._replace(**bare) if row.kind == "error" else row for row in rows]
    if suffix == ".mf4":  # a group for each kind: of frames with the same time, data come first
        return sorted(rows, key=lambda row: (row.time_s, row.kind == "error", row.kind == "remote"))
    return rows


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_frame_comes_back(tmp_path: Path, suffix: str) -> None:
    rows = frames(600)
    out = tmp_path / f"out{suffix}"
    text, err = ended(0, "export", log(tmp_path / "in.log", rows), "-o", out, "--json", tmp_path / "told.json")
    told = json.loads((tmp_path / "told.json").read_text())
    kept = held(rows, suffix)
    assert read(out) == kept  # times to the microsecond
    assert (told["frames_in"], told["frames_out"], told["bytes"]) == (600, len(kept), out.stat().st_size)
    assert sum(told["left_out"].values()) == 600 - len(kept)
    assert told["seconds"] == pytest.approx(rows[-1].time_s - rows[0].time_s, rel=1e-4)
    assert f"{out}: 600 frames in, {len(kept)} out" in text
    assert ("frames left out: .trc holds data frames only" in err) == (suffix == ".trc")
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_an_exported_recording_is_the_same_recording(tmp_path: Path, suffix: str) -> None:
    path = log_fake.write(tmp_path / "in.log", log_fake.log(12, 10, (3, 9)))
    assert run("export", path, "-o", tmp_path / f"out{suffix}")[0] == 0
    one, two = read_recording(path, RIG), read_recording(tmp_path / f"out{suffix}", RIG)
    assert one.fingerprint == two.fingerprint
    assert (one.frames, one.skipped, two.notes) == (two.frames, two.skipped, ())


def test_there_and_back_through_other_formats(tmp_path: Path) -> None:
    rows = [row for row in frames(300) if row.kind == "data"]
    path = log(tmp_path / "0.log", rows)
    for k, suffix in enumerate([".blf", ".asc", ".trc", ".blf", ".log"], 1):
        out = tmp_path / f"{k}{suffix}"
        assert run("export", path, "-o", out)[0] == 0
        path = out
    assert path.read_text() == (tmp_path / "0.log").read_text()


def test_several_logs_become_one_in_order_of_time(tmp_path: Path) -> None:
    rows = frames(400, channels="0")
    log(tmp_path / "b.log", rows[:150])
    one, two = rows[150:][::2], rows[150:][1::2]  # two buses at the same time
    log(tmp_path / "c.log", one)
    log(tmp_path / "a.log", [row._replace(channel="can1") for row in two])
    (tmp_path / "a.truth.csv").write_text("no log")
    status, _, err = run("export", tmp_path, "-o", tmp_path / "all.blf")
    assert (status, err) == (0, "")
    back = read(tmp_path / "all.blf")
    assert [row.time_s for row in back] == [row.time_s for row in rows]
    assert [row for row in back if row.channel == "can0"] == rows[:150] + one
    assert [row._replace(channel="can0") for row in back if row.channel == "can1"] == two


def test_a_torn_end_and_foreign_lines_are_skipped_and_told(tmp_path: Path) -> None:
    rows = frames(50)
    text = log(tmp_path / "in.log", rows).read_text()
    junk = "hello\n" + "x" * 10_000 + "\n\n"
    (tmp_path / "in.log").write_text(junk + text[:-4])
    out, err = ended(0, "export", tmp_path / "in.log", "-o", tmp_path / "out.log", "--json")
    assert (tmp_path / "out.log").read_text() == "".join(map(line_of, rows[:-1]))
    (told,) = json.loads(out)["logs"]
    assert told["skipped"] == {"torn or foreign line": 2, "torn line": 1}
    assert told["notes"] == ["torn at line 53: it has no line end; read up to there"]
    assert f"note: {tmp_path / 'in.log'}: 2 x torn or foreign line; 1 x torn line; torn at line 53" in err


@pytest.mark.parametrize("suffix", [".blf", ".asc", ".trc"])
def test_a_cut_file_of_another_format_goes_over_up_to_the_cut(tmp_path: Path, suffix: str) -> None:
    rows = [row for row in frames(6000) if row.kind == "data"]
    whole = tmp_path / f"in{suffix}"
    run("export", log(tmp_path / "in.log", rows), "-o", whole)
    whole.write_bytes(whole.read_bytes()[: -whole.stat().st_size // 4])
    _, err = ended(0, "export", whole, "-o", tmp_path / "out.log")
    assert "torn at" in err
    back = read(tmp_path / "out.log")
    assert 1000 < len(back) < len(rows)
    assert [row.time_s for row in back] == [row.time_s for row in rows[: len(back)]]


def test_a_clock_that_was_set_back(tmp_path: Path) -> None:
    rows = [row for row in frames(60, channels="0") if row.kind == "data"]
    rows[20:] = [row._replace(time_s=round(row.time_s - 1000, 6)) for row in rows[20:]]
    path = log(tmp_path / "in.log", rows)
    assert run("export", path, "-o", tmp_path / "out.log")[2] == ""
    assert read(tmp_path / "out.log") == rows
    status, out, err = run("export", path, "-o", tmp_path / "out.asc", "--json")
    early = len(rows) - 20
    assert (status, json.loads(out)["early"]) == (0, early)
    assert f"{early} frames are stamped before the first one and got its time" in err
    assert read(tmp_path / "out.asc") == [row._replace(time_s=max(row.time_s, rows[0].time_s)) for row in rows]


def test_stamps_and_dates_that_are_none(tmp_path: Path) -> None:
    text = "timestamp,arbitration_id,extended,remote,error,dlc,data\n"
    stamps = ["1700000001.5", "nan", "-1.0", "1e300"]
    (tmp_path / "in.csv").write_text(text + "".join(f"{stamp},0x123,0,0,0,1,AQ==\n" for stamp in stamps))
    _, err = ended(0, "export", tmp_path / "in.csv", "-o", tmp_path / "out.blf")
    assert "3 x time stamp absurd" in err
    assert [row.time_s for row in read(tmp_path / "out.blf")] == [1_700_000_001.5]
    (tmp_path / "in.asc").write_text("date Son Nov gestern\nbase hex\ninternal events logged\n 1.25 1 123 Rx d 1 07\n")
    _, err = ended(0, "export", tmp_path / "in.asc", "-o", tmp_path / "out.log")
    assert "its date cannot be read: times count from 1970" in err
    assert (tmp_path / "out.log").read_text() == "(1.250000) can0 123#07\n"


def test_a_file_that_gives_frames_for_ever_does_not_fill_the_disk(tmp_path: Path) -> None:
    path = endless(tmp_path / "endless.blf")
    out, err = ended(0, "export", path, "-o", tmp_path / "out.log", "--json")
    assert "240 bytes cannot hold more, the reader goes round in circles" in err
    assert json.loads(out)["bytes"] < 50_000_000


def test_a_reader_that_loops_without_a_frame_is_ended(tmp_path: Path) -> None:
    path = endless(tmp_path / "loop.blf", version=9)
    with mock.patch("drivers.logs.every_frame.UNLIMITED", Budget(stall_s=0.5)):
        status, line = refused(path, "-o", tmp_path / "out.blf")
    assert (status, line.endswith("stopped after 0 frames: the reader gave no frame for 1 s)")) == (1, True)


def refused(*words: object) -> tuple[int, str]:
    status, _, err = run("export", *words)
    assert err.count("\n") == 1
    return status, err.removeprefix("error: ").strip()


def test_what_cannot_be_done_is_one_line(tmp_path: Path) -> None:
    path = log(tmp_path / "in.log", frames(5))
    out = tmp_path / "out.blf"
    known = "known: .asc, .blf, .log, .mf4, .trc"
    assert refused(path, "-o", tmp_path / "x.db") == (2, f"{tmp_path / 'x.db'}: cannot write '.db'; {known}")
    assert refused(path, "-o", path) == (2, f"{path}: is one of the logs to convert; name another file with -o")
    assert refused(path, "-o", tmp_path / "no" / "x.blf")[0] == 2
    assert refused(tmp_path / "no.log", "-o", out) == (1, f"{tmp_path / 'no.log'}: no such file")
    (tmp_path / "lab.csv").write_text("time,T1\n0,20\n")
    assert refused(tmp_path / "lab.csv", "-o", out) == (1, f"{tmp_path / 'lab.csv'}: a lab CSV holds no frames")
    (tmp_path / "odd.log").write_text("hello\n")
    status, line = refused(tmp_path / "odd.log", "-o", out)
    assert (status, line) == (
        1, f"{out}: not written, no frames ({tmp_path / 'odd.log'}: no frame in it; 1 x torn or foreign line)",
    )  # fmt: skip
    assert not out.exists()


def test_mf4_without_its_package_says_how_to_install_it(tmp_path: Path) -> None:
    path = log(tmp_path / "in.log", frames(5))
    (tmp_path / "in.mf4").write_bytes(b"MDF")
    with mock.patch("drivers.logs.log_writer.find_spec", return_value=None):
        assert refused(path, "-o", tmp_path / "out.mf4") == (
            2, f"{tmp_path / 'out.mf4'}: writing MF4 needs asammdf: pip install 'ballscrew[mf4]'",
        )  # fmt: skip
    with mock.patch("drivers.logs.logs.find_spec", return_value=None):
        assert refused(tmp_path / "in.mf4", "-o", tmp_path / "out.blf") == (
            1, f"{tmp_path / 'in.mf4'}: reading MF4 needs asammdf: pip install 'ballscrew[mf4]'",
        )  # fmt: skip


def test_a_log_without_frames_among_others_is_an_error_and_the_others_go_over(tmp_path: Path) -> None:
    log(tmp_path / "in.log", frames(5))
    (tmp_path / "odd.log").write_text("hello\n")
    _, err = ended(1, "export", tmp_path / "in.log", tmp_path / "odd.log", "-o", tmp_path / "out.log")
    assert f"error: {tmp_path / 'odd.log'}: no frame in it" in err
    assert read(tmp_path / "out.log") == frames(5)


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("suffix", [".blf", ".asc", ".trc"])
def test_what_was_there_stays_if_a_conversion_fails(tmp_path: Path, suffix: str, error: BaseException) -> None:
    out = tmp_path / f"out{suffix}"
    out.write_text("older")
    writer = {".blf": can.BLFWriter, ".asc": can.ASCWriter, ".trc": can.TRCWriter}[suffix]
    rows = [row for row in frames(50) if row.kind == "data"]
    with mock.patch.object(writer, "on_message_received", side_effect=[None, None, error]):
        status, _, err = run("export", log(tmp_path / "in.log", rows), "-o", out)
    assert status == (2 if isinstance(error, OSError) else 130)
    assert err.strip() in (f"error: {out}: cannot be written: no space left on device", "stopped by Ctrl-C")
    assert out.read_text() == "older"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.log", out.name]


def test_logs_whose_clocks_overlap_are_two_recordings(tmp_path: Path) -> None:
    """Side by side they would be read as one machine, wrong by what the two differ."""
    rows = log_fake.log(20)
    one = log_fake.write(tmp_path / "one.log", rows)
    two = log_fake.write(tmp_path / "two.log", [row._replace(time=row.time + 10.0003) for row in rows])
    _, said = ended(1, "export", one, two, "-o", tmp_path / "both.log")
    assert " both have 0x" in said
    assert "export each to a file of its own" in said
    assert not (tmp_path / "both.log").exists()
    after = log_fake.write(tmp_path / "after.log", [row._replace(time=row.time + 30) for row in rows])
    assert run("export", one, after, "-o", tmp_path / "joined.log")[0] == 0
    other_bus = tmp_path / "can1.log"
    other_bus.write_text(two.read_text().replace("can0", "can1"))
    assert run("export", one, other_bus, "-o", tmp_path / "buses.log")[0] == 0


def test_logs_that_overlap_by_the_same_frames_are_one(tmp_path: Path) -> None:
    rows = log_fake.log(20)
    middle = rows[0].time + 10
    one = log_fake.write(tmp_path / "one.log", [row for row in rows if row.time < middle])
    two = log_fake.write(tmp_path / "two.log", [row for row in rows if row.time > middle - 3])
    _, said = ended(0, "export", one, two, "-o", tmp_path / "whole.log")
    assert "frame that the log before has too" in said
    assert (tmp_path / "whole.log").read_text() == log_fake.write(tmp_path / "same.log", rows).read_text()
