"""The loop of live with a bus, views and a publisher that are not there: who hears what, and when."""

import io

import numpy as np
import pytest
from rich.console import Console

from ballscrew.monitor import session as loop
from ballscrew.monitor.display import panel
from ballscrew.monitor.monitor import MOST_ALONE
from drivers.received import Notice
from estimator.step import Mode
from tests.ballscrew.monitor.conftest import Receiver
from tests.live_fake import DRIVE, changed, channel, dropped, since
from viz.drawing.scale import clock


def test_every_tick_is_told_shown_and_published(through):
    live, said, ticks = through
    assert len(ticks) == live.views.ticks >= 45
    assert len(live.publisher.sent_valid) >= 44  # the newest of each turn
    assert np.isfinite(live.publisher.positions).all()
    assert all(valid for _, valid in live.publisher.sent_valid)
    assert said == ["drive starts"]
    last = live.views.states[-1]
    assert (last.glances[-1].value, {glance.tone for glance in last.glances}) == ("ENDED", {"stale"})


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
    sent = len(live.publisher.sent_valid)
    for silent_s in (0.05, 0.6, 1.4, 1.55, 1.6):
        live.clock.silent_s = silent_s
        live._idle()
        live._publish()
    assert live.publisher.sent_valid[sent:] == [(live.latest.step.time_s, False)]
    assert live.latest.mode == Mode.INVALID
    assert live.latest.trust.why == ("no news of the drive",)


def test_what_has_come_is_estimated_before_the_model_goes_on_alone(session, frames):
    """A monitor that is behind takes silence in the past for silence now, and its frames would wait for ever."""
    live, _, _ = session(frames[:-400])
    live.clock.silent_s, last = 20.0, live.latest.step.time_s
    live.receiver.items = list(frames[-400:])
    live._idle()
    assert live.latest.step.time_s == last
    live._take(live.receiver.take(0.0))
    live.receiver.items = []
    live._idle()
    assert live.latest.provisional
    assert live.latest.step.time_s <= last + MOST_ALONE


def test_what_is_shown_of_a_silent_bus_does_not_look_like_news(session, frames):
    live, _, _ = session(frames[:200])
    live._ended, live.clock.silent_s = False, 20.0
    live._idle()
    live._shown = -np.inf
    live._show_status()
    shown = live.views.states[-1]
    assert shown.glances[-1].value == "NO FRAMES"
    assert {glance.tone for glance in shown.glances} == {"stale"}
    assert shown.table is None
    assert shown.time_s > live.monitor.ticker.clock.now


def test_a_drive_is_told_from_when_it_began(through):
    live, _, _ = through
    at_s = live.views.times[live.views.texts.index(("drive starts", "INFO"))]
    assert at_s == pytest.approx(21.0, abs=1.0)
    assert live.status().motion == f"driving since {clock(at_s)}"
    assert live.views.states[-1].table.error_um.shape == (1, loop.PLACES)


def test_after_a_night_the_views_begin_anew(session, frames, through):
    """Once, and before anything of the new run is shown."""
    evening = frames[:300]
    night = [frame._replace(time_s=frame.time_s + 10 * 3600.0) for frame in evening]
    live, said, _ = session([*evening, *night])
    assert "the estimate begins anew" in said
    ((before,),) = (live.views.begun,)
    assert live.views.ticks - before == pytest.approx(before, abs=2)
    assert through[0].views.begun == []


def test_a_silent_drive_alone_is_heard_of_too(session, frames):
    live, _, _ = session(dropped(frames, 40.0, [DRIVE]))
    assert live.publisher.sent_valid[-1][1] is False


def test_what_comes_late_is_not_valid(session, frames, monkeypatch):
    """A monitor that has fallen behind the bus must not pass off what was as what is."""
    monkeypatch.setattr(Receiver, "age_s", 2.0)
    live, _, ticks = session(frames)
    assert not any(valid for _, valid in live.publisher.sent_valid)
    assert ticks[-1].json()["why_invalid"] == ["the monitor is behind"]
    assert ticks[-1].json()["age_s"] == 2.0


def test_a_backlog_is_published_once(session, frames, monkeypatch):
    def everything(receiver: Receiver, wait_s: float) -> list:
        found, receiver.items = receiver.items, []
        return found

    monkeypatch.setattr(Receiver, "take", everything)
    monkeypatch.setattr(loop, "DRAIN_S", 600.0)  # however busy the machine is
    live, _, ticks = session(frames)
    assert len(ticks) >= 45
    assert len(live.publisher.sent_valid) <= 3


def test_validity_is_told_when_it_changes(session, frames):
    live, said, _ = session(dropped(frames, 30.0, [DRIVE], 36.0))
    told = [text for text in said if text.startswith("estimate valid")]
    assert told == ["estimate valid no longer: no news of the drive", "estimate valid again"]
    assert {why for _, why, _ in live.views.judged} >= {(), ("no news of the drive",)}
    assert {*live.views.published} == {"sent", "sent as invalid"}


def test_text_from_outside_is_no_markup(session, frames):
    live, _, _ = session(frames[:100])
    live.publisher.trouble = "not publishing: [/dev/ttyACM0] gone"
    console = Console(file=io.StringIO(), width=110)
    console.print(panel(live.status()))
    assert "[/dev/ttyACM0]" in console.file.getvalue()


def test_what_is_said_once_is_not_said_again(session, frames):
    live, said, _ = session(frames[:100])
    live.publisher.trouble = "not publishing: OSError: gone"
    for _ in range(3):
        live._tell()
    assert said.count("not publishing: OSError: gone") == 1


def test_the_panel_has_everything_with_its_unit(through):
    live, _, ticks = through
    console = Console(file=io.StringIO(), width=110, highlight=False)
    console.print(panel(live.status()))
    text = console.file.getvalue()
    for word in ("elongation", "um (2 sd)", "15 of 15 thermometers", "NIS", "frames", "dropped", "recording"):
        assert word in text
    line = live.status().line()
    assert "\n" not in line
    assert "mode update" in line or "mode predict" in line
    told = ticks[-1].json()
    assert set(told) >= {
        "t", "elongation_um", "sigma_um", "error_at_table_um", "mode", "channels", "nis", "frames", "dropped", "alarms",
        "suspects",
    }  # fmt: skip
    assert told["suspects"] == []


def test_readings_that_are_none_are_refused_and_no_frame_is_dropped(session, frames):
    """The same count for programs, for the terminal and at the end; a frame of the wrong length is dropped."""
    can_id, change = channel(5, lambda value, time_s: 32000)
    live, _, ticks = session(changed(frames, can_id, 30.0, change))
    count = ticks[-1].json()["refused"]["T05"]
    assert 13 <= count <= 16
    assert ticks[-1].json()["refused"] == {"T05": count}
    assert (ticks[-1].json()["dropped"], live.status().dropped) == (0, 0)
    assert f"{count} x out of range T05" in live.status().line()
    assert live.status().refused["T05"] - count in (0, 1)  # what came after the last tick that was told
    live, _, ticks = session(
        [f._replace(data=f.data[:7]) if f.id == DRIVE and since(frames, f) >= 30 else f for f in frames]
    )
    assert ticks[-1].json()["refused"] == {}
    assert live.status().dropped == sum(f.id == DRIVE and since(frames, f) >= 30 for f in frames)
