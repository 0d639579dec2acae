"""The page for a browser: under a policy that lets nothing out, with nothing else served beside it."""

from __future__ import annotations

import urllib.error
import urllib.request
from collections.abc import Iterator
from email.message import Message
from urllib.parse import parse_qs, urlsplit

import pytest

from estimator.errors import SetupError
from tests.processes import PATIENCE_S
from viz.viewer.web import WebPage


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
