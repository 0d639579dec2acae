"""ballscrew live: monitor a rig on a CAN bus."""

import math
import signal
import time
from collections.abc import Mapping
from contextlib import ExitStack
from ipaddress import ip_address
from pathlib import Path
from typing import Any

import click

from ballscrew.monitor.display import display, stop_asked
from ballscrew.monitor.explainer import Explainer
from ballscrew.monitor.json_lines import json_lines
from ballscrew.monitor.monitor import Monitor
from ballscrew.monitor.session import Session
from ballscrew.muting import chosen_thermometers, never_fused
from ballscrew.options import bus_options, channel_options, rig_options, save_option, terminal_options
from ballscrew.terminal import INTERRUPTED, Terminal
from ballscrew.workspace import Workspace, open_workspace
from drivers.bus.bus import BusAddress
from drivers.bus.publisher import Publisher
from drivers.bus.receiver import Receiver
from drivers.bus.rig_time import FastTime, RigTime
from drivers.decode.decode import Decoder
from drivers.frames import Tally
from drivers.received import Received
from drivers.recorder.earlier import earlier
from drivers.recorder.recorder import Recorder
from estimator.rig import Rig

LATE_S = 0.5  # wall time that frames of a bus faster than the rig may be late


@click.command("live")
@bus_options
@rig_options
@click.option("--record", type=click.Path(path_type=Path), metavar="DIR", help="Record every frame into this folder.")
@click.option("--fresh", is_flag=True, help="Begin anew, though a recording in DIR ended less than an hour ago.")
@click.option(
    "--view", type=click.Choice(["native", "web", "none"]), default="none", show_default=True,
    help="Show profile, elongation and residuals as they come: in the viewer's window, or on a page for a browser.",
)  # fmt: skip
@click.option("--bind", default="127.0.0.1", show_default=True, help="Address that views are served on.")
@save_option
@click.option(
    "--explain", is_flag=True,
    help="While rig and model part, ask in a process of its own what has changed since when; needs --record.",
)  # fmt: skip
@click.option("--publish", is_flag=True, help="Transmit Estimate and Compensation each second. Else nothing is sent.")
@channel_options
@click.option("--speed-up", default=1.0, show_default=True, help="The bus runs so many times faster than the rig.")
@click.option("--seconds", type=float, metavar="S", help="End after this time of the rig; default: never.")
@terminal_options
def command(
    terminal: Terminal, bus: BusAddress | None, rig_path: Path | None, model_path: Path | None, record: Path | None,
    fresh: bool, view: str, bind: str, rrd: Path | None, explain: bool, publish: bool, channels: str | None,
    no_displacement: bool, speed_up: float, seconds: float | None,
) -> int:  # fmt: skip
    """Listen to a rig on a CAN bus: profile, elongation and residuals as they come, alarms when rig and model part.

    Nothing is transmitted unless --publish is given. Ends with Ctrl-C or SIGTERM, every file closed. --json writes a
    line a tick.
    """
    if bus is None:
        raise click.UsageError("say which bus: --interface and --channel, as python-can names them")
    if explain and record is None:
        raise click.UsageError("--explain reads what was recorded: say where with --record DIR")
    if speed_up <= 0:
        raise click.UsageError("--speed-up must be above 0")
    work = open_workspace(terminal, [], rig_path, model_path)
    rig, model = work.rig, work.model
    never = never_fused(rig, chosen_thermometers(channels, rig), no_displacement)
    decoder = Decoder(rig, Tally())
    clock = _clock(rig, decoder, speed_up)
    with stop_asked() as stopped, ExitStack() as open_parts, display(terminal) as screen:
        about = {"bus": str(bus), "rig": rig.name, "model": model.name, "speed_up": speed_up}
        recorder = open_parts.enter_context(Recorder(record, about, own=decoder.own)) if record else None
        publisher = Publisher(rig, bus.open) if publish else None
        hear = [*([recorder.write] if recorder else []), *([publisher.heard] if publisher else [])]
        receiver = Receiver(bus.listen, clock, hear, bus.name)
        views, views_at = _views(terminal, rig, view, bind, rrd, open_parts)
        late_s = LATE_S * max(speed_up - 1.0, 0.0)
        lines = open_parts.enter_context(json_lines(terminal.json_path))
        monitor = Monitor(model, rig, lambda time_s: never, late_s)
        parts = earlier(record, about, time.time()) if record and not fresh and speed_up == 1.0 else []
        explainer = _explainer(work, about, recorder, open_parts) if explain and recorder else None
        session = Session(
            monitor, receiver, clock, str(bus), screen.say, lines, recorder, publisher, views, views_at, parts,
            explainer,
        )  # fmt: skip
        open_parts.callback(receiver.stop)
        if publisher is not None:
            open_parts.callback(publisher.close)
        end = time.monotonic() + (math.inf if seconds is None else seconds) / speed_up
        session.run(lambda: not stopped() and time.monotonic() < end, screen.show)
        session.finish()
        screen.end(session.status())
    return INTERRUPTED if stopped() == signal.SIGINT else 0


def _explainer(work: Workspace, about: Mapping[str, Any], recorder: Recorder, open_parts: ExitStack) -> Explainer:
    """Who asks what has changed, of the recording that is made.

    On a faster bus, whose stamps are ahead of the clock, of its last file.
    """

    def made() -> list[Path]:
        return earlier(recorder.path.parent, about, time.time()) if about["speed_up"] == 1.0 else [recorder.path]

    model = (work.model.folder or Path()) / work.model.name
    explainer = Explainer(made, ["--rig", str(work.rig.folder), "--model", str(model)])
    open_parts.callback(explainer.close)
    return explainer


def _clock(rig: Rig, decoder: Decoder, speed_up: float) -> RigTime:
    """The rig's own pace, or a faster one by the numbers of the scans."""
    if speed_up == 1.0:
        return RigTime(decoder.own)

    def closing(frame: Received) -> int | None:
        return decoder.closing(frame.id, frame.extended, frame.data)

    return FastTime(speed_up, rig.tick_s, closing, decoder.scan.modulus, decoder.own)


def _views(terminal: Terminal, rig: Rig, view: str, bind: str, save: Path | None, parts: ExitStack) -> tuple[Any, str]:
    """The views, and where they are to be seen; None where nobody asked."""
    if view == "none" and save is None:
        return None, ""
    from viz.live.live import LiveViews  # rerun takes half a second to import
    from viz.viewer.viewer import follow
    from viz.viewer.web import WebPage

    views = LiveViews(rig, "live", port=None if view == "none" else 0, bind=bind, save=save)
    parts.callback(views.close)
    if view != "none" and not ip_address(bind).is_loopback:
        terminal.warn(f"--bind {bind}: whoever reaches this address sees the views, without a password")
    if view == "web":
        page = WebPage(views.url, bind=bind)
        parts.callback(page.close)
        terminal.say(f"views: {page.address}")
        return views, page.address
    if view == "native":
        if follow(views.url) is None:
            terminal.warn(f"no screen here: open {views.url} in a viewer, or use --view web")
        return views, views.url
    return views, str(save)
