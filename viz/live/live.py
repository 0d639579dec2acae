"""Views of a run that goes on: served to viewers, kept in a file, or both.

Viewers come and go as they like, the disk may fill up and the server may die: none of it stops whoever shows the ticks.
"""

import shutil
import uuid
from pathlib import Path

import rerun as rr

from estimator.alarms.alarms import Alarm
from estimator.errors import BallscrewError, SetupError
from estimator.record import Sample
from estimator.rig import Rig
from estimator.step import Step
from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.drawing.file import begin, stream
from viz.drawing.series import Event
from viz.drawing.views import EVERYTHING, Span, sliding
from viz.lanes.standing import Judged, Standing
from viz.live.body import frame_of
from viz.live.layout import blueprint
from viz.live.outlet import Outlet
from viz.live.repeat import Repeated
from viz.live.rows import Rows
from viz.viewer.address import LOOPBACK, port_at

SERVED_S = 0.4  # of wall time between batches: each costs the same however many ticks are in it
KEPT_S = 60.0  # the same for the file: what a crash loses; shorter batches make the file larger
RESERVE = 64 << 20  # bytes to be left on the disk: the stream could not be ended any more once a write has failed


class LiveViews:
    """Profile, elongation, residuals and alarms as they come.

    url      what a viewer connects to, "" without a server
    """

    def __init__(
        self,
        rig: Rig,
        title: str,
        *,
        port: int | None,
        bind: str = LOOPBACK,
        save: Path | None = None,
        window_s: float = 3600.0,
        memory: str = "256MiB",
    ) -> None:
        """Serve on `bind` at `port` (0: any free one, None: no server), keep everything in `save`.

        title     what paths begin with, and so the names of lanes
        window_s  what the time axes show, s
        memory    what the server keeps for viewers that come late; the oldest goes first
        """
        if window_s <= 0:
            raise SetupError(f"window of {window_s:g} s: must be longer than 0")
        self.url = ""
        self._rig, self._title, self._id, self._window_s = rig, title, uuid.uuid4(), window_s
        self._outlets: list[Outlet] = []
        self._server: rr.RecordingStream | None = None  # ends with the stream that began it
        self._judged = Repeated[tuple[tuple[str, ...], tuple[Alarm, ...], str]]()
        try:
            if port is not None:
                self._serve(bind, port_at(bind, port), memory)
            if save is not None:
                self._keep(Path(save))
        except BallscrewError:
            self.close()
            raise

    def begin(self) -> None:
        """Another run begins, whose clock counts from 0 again: whoever looks on goes over to a recording of its own.

        In the old one the newest ticks would be the oldest, and what it ended with would stand there as if it were now.
        """
        if self.url:
            self._outlets[0].leave()
            rec = stream(uuid.uuid4())
            rec.connect_grpc(self.url)
            self._outlets[0] = self._served(rec)
        self._judged = Repeated()

    def show(self, sample: Sample, step: Step) -> None:
        """Show one tick, before the filter's start too; returns at once."""
        for outlet in self._outlets:
            outlet.tick(sample, step)

    def judge(self, time_s: float, why: tuple[str, ...], alarms: tuple[Alarm, ...], published: str = "") -> None:
        """Show from `time_s` on why the estimate is not to be relied on, empty: it is, the alarms that are on, and
        whether it is sent."""
        if self._judged.due((why, alarms, published), time_s):
            for outlet in self._outlets:
                outlet.event(Judged(time_s, why, alarms, published))

    def say(self, time_s: float, text: str, level: str = "INFO") -> None:
        """Log what happened at `time_s`, s; level is INFO, WARN or ERROR."""
        for outlet in self._outlets:
            outlet.event(Event(time_s, text, level))

    def stand(self, standing: Standing) -> None:
        """Show how things stand now."""
        for outlet in self._outlets:
            outlet.stand(standing)

    @property
    def trouble(self) -> str:
        """One line on what did not get out, "" while all is well."""
        return "; ".join(outlet.trouble for outlet in self._outlets if outlet.trouble)

    def flush(self) -> None:
        """Send what waits, and wait a moment for it."""
        for outlet in self._outlets:
            outlet.flush()

    def close(self) -> None:
        """Send what waits, end the file with its footer, and stop the server."""
        for outlet in self._outlets:
            outlet.close()
        if self._server is not None and not self.trouble:
            self._server.disconnect()

    def _serve(self, bind: str, port: int, memory: str) -> None:
        rec = stream(self._id)
        pages = [f"http://{bind}:*"]  # whose scripts may read the stream: those that this address serves
        try:
            sink = rr.GrpcServerSink(bind, port, server_memory_limit=memory, cors_allow_origin=pages)
            rec.set_sinks(sink)
            rec.flush(timeout_sec=5.0)
        except (RuntimeError, ValueError) as error:
            raise SetupError(f"{bind}:{port}: no live views ({error}; memory limit {memory})") from error
        self.url, self._server = sink.uri, rec
        self._outlets.append(self._served(rec))

    def _served(self, rec: rr.RecordingStream) -> Outlet:
        return Outlet(self.url, rec, self._begun(rec, sliding(self._window_s), newest=True), SERVED_S)

    def _keep(self, path: Path) -> None:
        rec = stream(self._id, path)
        rows = self._begun(rec, EVERYTHING, newest=False)
        self._outlets.append(Outlet(str(path), rec, rows, KEPT_S, lambda: _full(path.parent)))

    def _begun(self, rec: rr.RecordingStream, span: Span, newest: bool) -> Rows:
        """What a stream shows, once it has its layout and the rig's name."""
        root, frame = paths.root(self._title), frame_of(self._rig) if self._rig.screw is not None else None
        begin(rec, blueprint(root, self._rig, frame, span, newest), self._rig.name)
        return Rows(Entity(rec) / root, self._rig, newest, self._window_s)


def _full(folder: Path) -> str:
    """Why nothing can be written now, "" if it can."""
    try:
        free = shutil.disk_usage(folder).free
    except OSError as error:
        return f"the disk does not answer ({error.strerror})"
    return "" if free > RESERVE else f"the disk is nearly full, less than {RESERVE / 1e6:.0f} MB are left"
