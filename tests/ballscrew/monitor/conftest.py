"""A session with a bus, views and a publisher that are not there."""

from collections.abc import Callable, Iterator

import pytest

from ballscrew.monitor import session as loop
from ballscrew.monitor.monitor import Monitor
from ballscrew.monitor.session import Session
from ballscrew.monitor.status import Status
from tests.live_fake import Frames, rig_frames


class Clock:
    silent_s, trouble = 0.0, ""

    def silence(self) -> float:
        return self.silent_s


class Receiver:
    """Gives its items ten at a time."""

    state, failure, missed, dropped, errors, age_s = "open", None, 0, 0, 0, 0.0

    def __init__(self, items: list) -> None:
        self.items, self.frames = list(items), len(items)

    @property
    def waiting(self) -> bool:
        return bool(self.items)

    def start(self) -> None: ...

    def stop(self) -> None: ...

    def take(self, wait_s: float) -> list:
        found, self.items = self.items[:10], self.items[10:]
        return found


class Publisher:
    trouble, sent = "", 0

    def __init__(self) -> None:
        self.sent_valid, self.positions = [], []

    def start(self) -> None: ...

    def send(self, step, trust, position_mm) -> None:
        self.sent_valid.append((step.time_s, trust.valid))
        self.positions.append(position_mm)


class Views:
    trouble = ""

    def __init__(self) -> None:
        self.ticks, self.texts, self.states, self.judged, self.published = 0, [], [], [], []
        self.times, self.begun = [], []

    def begin(self) -> None:
        self.begun.append(self.ticks)

    def show(self, sample, step) -> None:
        self.ticks += 1

    def judge(self, time_s, why, alarms, published) -> None:
        self.judged.append((time_s, why, alarms))
        self.published.append(published)

    def say(self, time_s, text, level) -> None:
        self.texts.append((text, level))
        self.times.append(time_s)

    def stand(self, standing) -> None:
        self.states.append(standing)


@pytest.fixture(scope="module")
def frames(request) -> Frames:
    """Of a rig until the END_S of the module that asks, or 45 s."""
    return rig_frames(getattr(request.module, "END_S", 45.0))


Held = tuple[Session, list[str], list[Status]]


@pytest.fixture(scope="module")
def session(paper) -> Iterator[Callable[[list], Held]]:
    """session(items): all parts of it, with what was said and each status; a busy machine takes its time at the end."""

    def of(items: list) -> Held:
        said, ticks = [], []
        session = Session(
            Monitor(paper[1], paper[0]), Receiver(items), Clock(), "a bus", lambda text, level: said.append(text),
            ticks.append, None, Publisher(), Views(),
        )  # fmt: skip
        session.run(lambda: bool(session.receiver.items), lambda status: None)
        session.finish()
        return session, said, ticks

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loop, "DRAIN_S", 1000.0)
        yield of


@pytest.fixture(scope="module")
def through(session, frames) -> Held:
    """The session that hears all frames; to be looked at only."""
    return session(frames)
