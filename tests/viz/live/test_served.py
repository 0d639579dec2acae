"""Who can reach live views, and what cannot be served is said."""

import socket
import sys
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from estimator.errors import InputError, SetupError
from estimator.rig import Rig
from tests.processes import PATIENCE_S, until
from tests.viz.live.conftest import Fed, show
from viz.live.live import LiveViews
from viz.viewer import viewer
from viz.viewer.address import free_port
from viz.viewer.web import WebPage

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc, or has no screen")


@contextmanager
def served(rig: Rig, **how: Any) -> Iterator[LiveViews]:
    views = LiveViews(rig, "live", **{"port": 0, **how})
    try:
        yield views
    finally:
        views.close()


def listening(port: int) -> set[str]:
    """Addresses at which this machine listens on a port, as the kernel writes them."""
    lines = [line.split() for name in ("tcp", "tcp6") for line in Path(f"/proc/net/{name}").read_text().splitlines()]
    return {cells[1].split(":")[0] for cells in lines if cells[1].endswith(f":{port:04X}") and cells[3] == "0A"}


@LINUX
def test_stream_and_page_are_served_on_the_loopback_only(rig: Rig) -> None:
    with served(rig) as views:
        page = WebPage(views.url)
        ports = [urlsplit(address).port for address in (views.url.removeprefix("rerun+"), page.address)]
        assert [listening(port) for port in ports] == [{"0100007F"}] * 2
        page.close()
        assert listening(ports[1]) == set()
    until(lambda: not listening(ports[0]))  # the server lets go of it in its own time


@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_a_late_viewer_gets_it_all(fed: Fed, tmp_path: Path) -> None:
    got = tmp_path / "got.rrd"

    def seen() -> list[float]:
        try:
            chunks = RrdReader(got).stream().filter(content="/live/channels/innovation/1").to_chunks()
        except (ValueError, RuntimeError):  # not there yet, or in the middle of being written
            return []
        batches = [chunk.to_record_batch() for chunk in chunks if not chunk.is_static]
        return [t / 1e9 for batch in batches for t in batch.column("time").cast("int64").to_pylist()]

    with served(fed.run.rig) as views:
        show(views, fed.ticks[:100])
        late = viewer.start([views.url, "--save", str(got)], free_port())
        try:
            until(lambda: len(seen()) == 100)
        finally:
            late.terminate()
            late.wait(PATIENCE_S)
        show(views, fed.ticks[100:200])
        assert views.trouble == ""
    np.testing.assert_array_equal(sorted(seen()), fed.run.track.time_s[:100])


@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_a_run_that_begins_anew_is_a_recording_of_its_own(fed: Fed, tmp_path: Path) -> None:
    got = tmp_path / "got.rrd"

    def seen() -> list[int]:
        """Ticks of each recording."""
        try:
            reader = RrdReader(got)
            streams = [reader.stream(store=each) for each in reader.recordings()]
            found = [each.filter(content="/live/channels/innovation/1").to_chunks() for each in streams]
            return [sum(chunk.num_rows for chunk in chunks if not chunk.is_static) for chunks in found]
        except (ValueError, RuntimeError):
            return []

    with served(fed.run.rig) as views:
        looks_on = viewer.start([views.url, "--save", str(got)], free_port())
        try:
            show(views, fed.ticks[:100])
            views.begin()
            show(views, fed.ticks[:50])
            until(lambda: sorted(seen()) == [50, 100])
        finally:
            looks_on.terminate()
            looks_on.wait(PATIENCE_S)
        assert views.trouble == ""


@pytest.mark.parametrize(("site", "allowed"), [("http://127.0.0.1:1234", True), ("http://evil.example", False)])
def test_scripts_of_other_sites_may_not_read_the_stream(rig: Rig, site: str, allowed: bool) -> None:
    with served(rig) as views:
        address = views.url.removeprefix("rerun+").replace("/proxy", "/rerun.sdk_comms.v1alpha1.MessageProxyService/x")
        headers = {"Origin": site, "Access-Control-Request-Method": "POST"}
        request = urllib.request.Request(address, headers=headers, method="OPTIONS")
        direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        with direct.open(request, timeout=PATIENCE_S) as answer:
            assert (answer.headers["Access-Control-Allow-Origin"] is not None) == allowed


def test_the_server_forgets_beyond_its_limit(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[str, Any] = {}
    sink = rr.GrpcServerSink

    def spy(bind: str, port: int, **how: Any) -> Any:
        asked.update(how, bind=bind)
        return sink(bind, port, **how)

    monkeypatch.setattr(rr, "GrpcServerSink", spy)
    with served(rig, memory="16MiB"):
        assert (asked["server_memory_limit"], asked["bind"]) == ("16MiB", "127.0.0.1")


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"bind": "0.0.0.0"}, "bind 0.0.0.0: not one address"),
        ({"bind": "localhost"}, "bind localhost: not an IPv4 address"),
        ({"bind": "300.1.1.1"}, "bind 300.1.1.1: not an IPv4 address"),
        ({"bind": "192.0.2.1"}, "192.0.2.1:0: cannot listen there"),
        ({"port": 70000}, "port 70000: not between"),
        ({"memory": "much"}, "memory limit much"),
        ({"window_s": 0.0}, "window of 0 s"),
    ],
)
def test_what_cannot_be_served_is_said_in_a_line(rig: Rig, how: dict[str, Any], said: str) -> None:
    with pytest.raises(SetupError, match=said) as error:
        LiveViews(rig, "live", **{"port": 0, **how})
    assert "\n" not in str(error.value)


def test_a_taken_port_is_said_before_anything_starts(rig: Rig, tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with pytest.raises(SetupError, match=rf"127.0.0.1:{port}: cannot listen there .*; choose another port"):
            LiveViews(rig, "live", port=port, save=tmp_path / "x.rrd")
        with pytest.raises(SetupError, match=rf"127.0.0.1:{port}: cannot listen"):
            WebPage("rerun+http://127.0.0.1:9/proxy", port=port)
    assert not (tmp_path / "x.rrd").exists()


@pytest.mark.parametrize("name", ["nowhere/x.rrd", "."])
def test_a_file_that_cannot_be_written_is_said(rig: Rig, tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"there is no folder|cannot be written"):
        LiveViews(rig, "live", port=0, save=tmp_path / name)


@LINUX
def test_no_viewer_follows_without_a_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert viewer.follow("rerun+http://127.0.0.1:9/proxy") is None


def test_a_viewer_follows_with_limited_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    url, started = "rerun+http://127.0.0.1:9/proxy", []
    monkeypatch.setattr(viewer, "has_screen", lambda: True)
    monkeypatch.setattr(viewer, "start", lambda arguments, port: started.append(arguments))
    viewer.follow(url)
    assert started == [["--memory-limit", viewer.MEMORY, "--connect", url]]
