"""The loop of live with a bus, views and a publisher that are not there: who hears what, and when."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from rich.console import Console

from ballscrew.monitor import Monitor
from ballscrew.session import Session
from ballscrew.status import Status
from drivers.receiver import Notice
from estimator.errors import SetupError
from estimator.model import load_model
from estimator.rig_file import load_rig
from estimator.step import Mode
from tests.live_fake import DRIVE, Frames, dropped, rig_frames

RECORDINGS = Path(__file__).parents[1] / "recordings"


class Clock:
    silent_s = 0.0

    def silence(self) -> float:
        return self.silent_s


class Receiver:
    """Gives its items ten at a time."""

    state, failure, dropped = "open", None, 0

    def __init__(self, items: list) -> None:
        self.items, self.frames = list(items), len(items)

    def start(self) -> None: ...

    def stop(self) -> None: ...

    def take(self, wait_s: float) -> list:
        found, self.items = self.items[:10], self.items[10:]
        return found


class Publisher:
    trouble, sent = "", 0

    def __init__(self) -> None:
        self.heard_frames, self.modes = 0, []

    def send(self, now_s, step, trust, position_mm) -> None:
        self.modes.append((now_s, trust.valid))

    def heard(self, frame) -> None:
        self.heard_frames += 1


class Views:
    trouble = ""

    def __init__(self) -> None:
        self.ticks, self.texts, self.states = 0, [], []

    def show(self, sample, step) -> None:
        self.ticks += 1

    def say(self, time_s, text, level) -> None:
        self.texts.append((text, level))

    def status(self, markdown) -> None:
        self.states.append(markdown)


@pytest.fixture(scope="module")
def parts():
    rig = load_rig(RECORDINGS)
    return rig, load_model(RECORDINGS / "model.toml")


@pytest.fixture(scope="module")
def frames() -> Frames:
    return rig_frames(45.0)


@pytest.fixture
def session(parts):
    """session(items): all parts of it, with what was said and each status."""

    def of(items: list) -> tuple[Session, list[str], list[Status]]:
        said, ticks = [], []
        session = Session(
            Monitor(parts[1], parts[0]), Receiver(items), Clock(), "a bus", lambda text, level: said.append(text),
            ticks.append, None, Publisher(), Views(),
        )  # fmt: skip
        session.run(lambda: bool(session.receiver.items), lambda status: None)
        session.finish()
        return session, said, ticks

    return of


def test_every_tick_is_told_shown_and_published(session, frames):
    live, said, ticks = session(frames)
    assert len(ticks) == live.views.ticks == len(live.publisher.modes) >= 45
    assert live.publisher.heard_frames == len(frames)
    assert all(valid for _, valid in live.publisher.modes)
    assert not said
    assert "elongation" in live.views.states[0]


def test_alarms_and_what_happens_to_the_bus_reach_the_views(session, frames):
    items = [Notice("bus lost: OSError: gone"), *dropped(frames, 30.0, [0x211])]
    live, said, _ = session(items)
    assert said[0] == "bus lost: OSError: gone"
    assert ("bus lost: OSError: gone", "WARN") in live.views.texts
    alarms = [text for text, level in live.views.texts if text.startswith("alarm: ") and level == "WARN"]
    assert any("Telemeter2 (0x211) is missing" in text for text in alarms)
    assert any(text.startswith("alarm: T05 at 415 mm is not read, since ") for text in alarms)


def test_who_relies_on_it_hears_of_a_silent_bus_before_the_next_tick(session, frames):
    live, _, _ = session(frames[:-400])
    sent = len(live.publisher.modes)
    for silent_s in (0.05, 0.3, 0.55, 0.6):
        live.clock.silent_s = silent_s
        live._idle()
    assert live.publisher.modes[sent:] == [(live.latest.step.time_s, False)]
    assert live.latest.mode == Mode.INVALID
    assert live.latest.trust.why == ("no news of the drive",)


def test_a_silent_drive_alone_is_heard_of_too(session, frames):
    live, _, _ = session(dropped(frames, 40.0, [DRIVE]))
    assert live.publisher.modes[-1][1] is False


def test_an_interface_that_cannot_be_is_the_end(session):
    Receiver.failure = SetupError("--interface nonsense: no such interface")
    try:
        with pytest.raises(SetupError, match="nonsense"):
            session([Notice("x")])
    finally:
        Receiver.failure = None


def test_what_is_said_once_is_not_said_again(session, frames):
    live, said, _ = session(frames[:100])
    live.publisher.trouble = "not publishing: OSError: gone"
    for _ in range(3):
        live._tell()
    assert said.count("not publishing: OSError: gone") == 1


def test_the_panel_has_everything_with_its_unit(session, frames):
    live, _, ticks = session(frames)
    console = Console(file=io.StringIO(), width=110, highlight=False)
    console.print(live.status().panel())
    text = console.file.getvalue()
    for word in ("elongation", "um (2 sd)", "15 of 15 thermometers", "NIS", "frames", "dropped", "recording"):
        assert word in text
    line = live.status().line()
    assert "\n" not in line
    assert "mode update" in line or "mode predict" in line
    told = ticks[-1].json()
    assert set(told) >= {
        "t", "elongation_um", "sigma_um", "error_at_table_um", "mode", "channels", "nis", "frames", "dropped", "alarms",
    }  # fmt: skip


def test_before_the_first_tick_the_status_says_so(session):
    live, _, _ = session([])
    assert "waiting for the first tick" in live.status().line()
