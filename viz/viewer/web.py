"""The live views in a browser: the web viewer that came with the package, cut off from everything but the stream.

Its stock page asks for fonts, for its own new versions, and reports its use. Here the page comes without those links,
under a policy by which the browser connects it to the live stream and to nothing else.
"""

import base64
import hashlib
import re
import socket
import tempfile
import threading
import time
import urllib.error
import urllib.request
from collections import deque
from contextlib import suppress
from functools import partial
from http import HTTPStatus
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import quote, urlsplit

from estimator.errors import SetupError
from viz.viewer.address import LOOPBACK, free_port, port_at
from viz.viewer.viewer import START_S, start

FILES = ("/", "/re_viewer.js", "/re_viewer_bg.wasm", "/favicon.ico")
KINDS = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript",
    ".wasm": "application/wasm",
    ".ico": "image/x-icon",
}
MOST_OPEN = 32  # connections; a browser opens six
STREAM = re.compile(r"rerun\+http://([\w.-]+:\d+)/proxy")
OUTSIDE = re.compile(rb"<link\b[^>]*https?://[^>]*>")
INLINE = re.compile(rb"<script>(.*?)</script>", re.DOTALL)


class WebPage:
    """A page that shows the stream at `url`, served on `bind` at `port` (0: any free one).

    address   what to open in a browser
    """

    def __init__(self, url: str, *, port: int = 0, bind: str = LOOPBACK) -> None:
        stream = STREAM.fullmatch(url)
        if not stream:
            raise SetupError(f"{url}: not a live stream; expected rerun+http://ADDRESS:PORT/proxy")
        port = port_at(bind, port)
        self._folder = tempfile.TemporaryDirectory(prefix="ballscrew-web-")
        try:
            page = _fetch(url, Path(self._folder.name))
            self._server = _Server(bind, port, Path(self._folder.name), policy(page, f"http://{stream[1]}"))
        except BaseException:
            self._folder.cleanup()
            raise
        shown = f"url={quote(url, safe='')}&persist=0&hide_welcome_screen=1&theme=dark"
        self.address = f"http://{bind}:{port}/?{shown}"
        threading.Thread(target=self._server.serve_forever, name="web page", daemon=True).start()

    def close(self) -> None:
        """Stop serving."""
        self._server.shutdown()
        self._server.server_close()
        self._folder.cleanup()


def policy(page: bytes, stream: str) -> str:
    """The Content-Security-Policy of a page: its own files and scripts, and connections to `stream` only."""
    hashes = [base64.b64encode(hashlib.sha256(script).digest()).decode() for script in INLINE.findall(page)]
    scripts = " ".join(f"'sha256-{each}'" for each in hashes)
    return "; ".join(
        [
            "default-src 'none'",
            f"script-src 'self' 'wasm-unsafe-eval' {scripts}",
            "style-src 'unsafe-inline'",
            "img-src 'self' data: blob:",
            f"connect-src 'self' {stream}",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
        ]
    )


class _Server(ThreadingHTTPServer):
    """Serves the files in a folder and nothing else, to whoever asks for this very address."""

    request_queue_size = 128  # with five, who comes among many at once waits for seconds

    def __init__(self, bind: str, port: int, folder: Path, rules: str) -> None:
        self._open: deque[socket.socket] = deque()
        super().__init__((bind, port), partial(_Handler, directory=str(folder)))
        self.host = f"{bind}:{port}"
        self.headers = {
            "Content-Security-Policy": rules,
            "X-Content-Type-Options": "nosniff",
            "X-DNS-Prefetch-Control": "off",
            "Referrer-Policy": "no-referrer",
            "Cache-Control": "no-store",
        }

    def process_request(self, request: Any, client_address: Any) -> None:
        """In a thread of its own; of too many connections the oldest goes: who asks nothing keeps nobody out."""
        self._open.append(request)
        if len(self._open) > MOST_OPEN:
            with suppress(OSError):
                self._open.popleft().shutdown(socket.SHUT_RDWR)  # its own thread wakes up, and closes it
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        with suppress(ValueError):
            self._open.remove(request)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that goes away in mid answer is nothing to tell."""


class _Handler(SimpleHTTPRequestHandler):
    server: _Server
    timeout = 30.0
    extensions_map = KINDS

    def send_head(self) -> Any:
        """Begin to answer: with a file, or with what is wrong with the question."""
        if self.headers["Host"] != self.server.host:  # another site's name that was made to lead here
            return self.send_error(HTTPStatus.MISDIRECTED_REQUEST)
        if urlsplit(self.path).path not in FILES:
            return self.send_error(HTTPStatus.NOT_FOUND)
        return super().send_head()

    def end_headers(self) -> None:
        """Every answer, an error too, is under the policy."""
        for name, value in self.server.headers.items():
            self.send_header(name, value)
        super().end_headers()

    def log_message(self, format: str, *args: Any) -> None:
        """The terminal is the command's."""


def _file(folder: Path, path: str) -> Path:
    return folder / (path.strip("/") or "index.html")


def _fetch(url: str, folder: Path) -> bytes:
    """Take the files from the package, whose program can only serve them; returns the page without links to others."""
    port = free_port()
    program = start(["--serve-web", "--web-viewer-port", str(port), url], free_port())
    try:
        for path in FILES:
            _file(folder, path).write_bytes(_get(f"http://{LOOPBACK}:{port}{path}"))
    finally:
        program.kill()
        program.wait()
    index = _file(folder, "/")
    page = OUTSIDE.sub(b"", index.read_bytes())
    index.write_bytes(page)
    return page


def _get(address: str) -> bytes:
    direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    end = time.monotonic() + START_S
    while True:
        try:
            with direct.open(address, timeout=START_S) as answer:
                return bytes(answer.read())
        except (urllib.error.URLError, ConnectionError) as error:
            if time.monotonic() > end or isinstance(error, urllib.error.HTTPError):
                raise SetupError(f"the web viewer of the package does not answer ({error})") from error
            time.sleep(0.1)  # not up yet
