"""The page for a browser: under a policy that lets nothing out, with nothing else served beside it."""

import socket
import struct
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack
from email.message import Message
from urllib.parse import parse_qs, urlsplit

import pytest

from estimator.errors import SetupError
from tests.processes import PATIENCE_S, until
from viz.viewer.web import MOST_OPEN, WebPage


@pytest.fixture(scope="module")
def page() -> Iterator[WebPage]:
    page = WebPage("rerun+http://127.0.0.1:4321/proxy")
    yield page
    page.close()


def ask(page: WebPage, path: str, host: str = "") -> tuple[int, Message, bytes]:
    """Status, headers and body of an answer."""
    at = urlsplit(page.address)
    request = urllib.request.Request(f"http://{at.netloc}{path}", headers={"Host": host or at.netloc})
    direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    try:
        with direct.open(request, timeout=PATIENCE_S) as answer:
            return answer.status, answer.headers, answer.read()
    except urllib.error.HTTPError as error:
        with error:
            return error.code, error.headers, error.read()


@pytest.mark.parametrize(
    ("path", "kind", "begin"),
    [
        ("/?url=x", "text/html; charset=utf-8", b"<!doctype html>"),
        ("/re_viewer.js", "text/javascript", b""),
        ("/re_viewer_bg.wasm", "application/wasm", b"\0asm"),
        ("/favicon.ico", "image/x-icon", b""),
    ],
)
def test_the_page_and_its_parts_are_under_the_policy(page: WebPage, path: str, kind: str, begin: bytes) -> None:
    status, headers, body = ask(page, path)
    assert (status, headers["Content-Type"], body[: len(begin)]) == (200, kind, begin)
    rules = dict(rule.split(" ", 1) for rule in headers["Content-Security-Policy"].split("; "))
    assert rules["default-src"] == "'none'"
    assert rules["connect-src"] == "'self' http://127.0.0.1:4321"
    assert "unsafe" not in rules["script-src"].replace("'wasm-unsafe-eval'", "")
    assert rules["script-src"].count("sha256-") == 2


def test_the_page_links_to_nobody(page: WebPage) -> None:
    assert b"<link rel=" in ask(page, "/")[2]
    assert b"fonts" not in ask(page, "/")[2]
    assert parse_qs(urlsplit(page.address).query)["url"] == ["rerun+http://127.0.0.1:4321/proxy"]


@pytest.mark.parametrize(
    ("path", "host", "status"),
    [("/etc/passwd", "", 404), ("/../../etc/passwd", "", 404), ("/sw.js", "", 404), ("/", "evil.example", 421)],
)
def test_nothing_else_is_served(page: WebPage, path: str, host: str, status: int) -> None:
    answer = ask(page, path, host)
    assert answer[0] == status
    assert answer[1]["Content-Security-Policy"].startswith("default-src 'none'")


@pytest.mark.parametrize("url", ["http://127.0.0.1:9", "rerun+http://a;b:9/proxy", "rerun+http://127.0.0.1:9/proxy; *"])
def test_a_page_shows_live_streams_only(url: str) -> None:
    with pytest.raises(SetupError, match="not a live stream"):
        WebPage(url)


def test_connections_that_ask_nothing_keep_nobody_out(page: WebPage, capfd: pytest.CaptureFixture[str]) -> None:
    at = urlsplit(page.address)
    before = threading.active_count()
    with ExitStack() as half_open:
        idle = [half_open.enter_context(socket.create_connection((at.hostname, at.port))) for _ in range(300)]
        assert ask(page, "/")[0] == 200
        idle[0].settimeout(PATIENCE_S)
        assert idle[0].recv(1) == b""  # the oldest was closed
        until(lambda: threading.active_count() <= before + MOST_OPEN + 1)
        torn = socket.create_connection((at.hostname, at.port))
        torn.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        torn.sendall(f"GET /re_viewer_bg.wasm HTTP/1.0\r\nHost: {at.netloc}\r\n\r\n".encode())
        torn.recv(1)
        torn.close()  # in mid answer, by a reset
    until(lambda: threading.active_count() <= before)
    assert capfd.readouterr().err == ""
