"""A line a tick for programs: on a full disk, and to a reader that stalls."""

import io
import json
import os

import pytest

from ballscrew.monitor.json_lines import WAITING, JsonLines
from tests.processes import until


def test_json_lines_on_a_full_disk_cost_lines_and_nothing_else(session, frames):
    class Disk(io.BytesIO):
        written, fails = 0, (1, 2)

        def write(self, line) -> int:
            self.written += 1
            if self.written - 1 in self.fails:
                raise OSError(28, "No space left on device")
            return super().write(line)

    _, _, ticks = session(frames[:400])
    disk, full = Disk(), "--json: No space left on device: lines are lost"
    lines = JsonLines(disk)
    for k, (trouble, lost) in enumerate((("", 0), (full, 1), (full, 2), ("", 2))):
        lines(ticks[k])
        until(lambda told=(k + 1, trouble, lost): told == (disk.written, lines.trouble, lines.lost))
    lines.close()
    assert json.loads(disk.getvalue().splitlines()[-1])["t"] == pytest.approx(ticks[3].moment.step.time_s, abs=1e-9)


def test_a_reader_that_stalls_holds_up_no_tick_and_gets_what_there_was_room_for(session, frames):
    _, _, ticks = session(frames[:400])
    reader, writer = os.pipe()
    asked = 0
    with open(writer, "wb", buffering=0) as file:
        lines = JsonLines(file)
        while lines.lost < WAITING:
            lines(ticks[0])
            asked += 1
        assert lines.trouble == "--json: their reader is behind: lines are lost"
        with open(reader, "rb") as late:
            texts = {late.readline() for _ in range(asked - lines.lost)}
        assert [json.loads(text)["t"] for text in texts] == [pytest.approx(ticks[0].moment.step.time_s, abs=1e-9)]
        lines.close()
        assert lines.trouble == ""


def test_before_the_first_tick_the_status_says_so(session):
    live, _, _ = session([])
    assert "waiting for the first tick" in live.status().line()
