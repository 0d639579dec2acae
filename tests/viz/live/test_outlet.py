"""Live views stop nobody: what cannot get out waits, is told, and is given up in time."""

from pathlib import Path
from typing import Any

import pytest
import rerun as rr

from tests.viz.live.conftest import Fed, show
from tests.viz.live.test_served import served
from tests.viz_read import rows
from viz.live import live, outlet
from viz.live.rows import Rows


def test_a_full_disk_is_told_and_the_file_goes_on_when_there_is_room(
    fed: Fed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "x.rrd"
    with served(fed.run.rig, port=None, save=file) as views:
        monkeypatch.setattr(live, "RESERVE", 1 << 62)
        show(views, fed.ticks[:100])
        assert "x.rrd: nothing gets out, ticks wait (the disk is nearly full" in views.trouble
        monkeypatch.undo()
        views.flush()
        assert views.trouble == ""
    assert len(rows(file, "/live/channels/innovation/1", "Scalars:scalars")[0]) == 100


def test_ticks_wait_while_a_viewer_hangs(fed: Fed, monkeypatch: pytest.MonkeyPatch) -> None:
    def hangs(*_: Any, **__: Any) -> None:
        raise RuntimeError("Flush timed out")

    with served(fed.run.rig) as views:
        monkeypatch.setattr(rr.RecordingStream, "flush", hangs)
        show(views, fed.ticks[:100], 20)
        assert "nothing gets out, ticks wait (Flush timed out)" in views.trouble
        monkeypatch.undo()
        views.flush()
        assert views.trouble == ""


def test_a_view_that_breaks_is_counted(fed: Fed, monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks(*_: Any) -> None:
        raise ValueError("no such colour")

    with served(fed.run.rig) as views:
        monkeypatch.setattr(Rows, "send", breaks)
        show(views, fed.ticks[:40], 20)
        assert "2 batches failed, the last one: ValueError: no such colour" in views.trouble
        show(views, fed.ticks[40:200], 20)
        assert "10 or more batches failed" in views.trouble


def test_too_many_ticks_are_given_up_and_counted(fed: Fed, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outlet, "WAITING", 30)
    with served(fed.run.rig, port=None, save=Path("/dev/null")) as views:
        for sample, step in fed.ticks[:100]:
            views.show(sample, step)
        assert "50 or more ticks were given up" in views.trouble
