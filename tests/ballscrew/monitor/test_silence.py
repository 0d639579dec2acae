"""A silent bus, and frames whose stamps are no news of the rig: the model goes on alone, and is taken back."""

import pytest

from ballscrew.monitor.monitor import Monitor
from drivers.bus.rig_time import RigTime
from estimator.step import Mode
from tests.ballscrew.monitor.test_monitor import copied
from tests.live_fake import DRIVE, dropped, since

END_S = 66.0


@pytest.fixture(scope="module")
def half_a_minute(paper, frames) -> Monitor:
    """A monitor that has lived so long; to be copied."""
    monitor = Monitor(paper[1], paper[0])
    assert [m for f in frames if since(frames, f) < 30 for m in monitor.feed(f)]
    return monitor


def test_on_a_silent_bus_the_model_goes_on_alone_and_is_taken_back(paper, frames, half_a_minute):
    """A silence of 20 s: provisional ticks meanwhile, none of which is left in the estimate after it."""
    heard, runs = dropped(frames, 30, None, 50), []
    for waits in (False, True):
        monitor, moments = copied(half_a_minute, paper), []
        for before, frame in zip([heard[0], *heard], heard, strict=False):
            if not 30 <= since(frames, frame) < 65:
                continue
            if waits and frame.time_s - before.time_s > 15:
                for passed in range(1, 20):
                    moments += monitor.idle(passed)
            moments += monitor.feed(frame)
        runs.append(moments)
    moments = runs[1]
    alone = [m for m in moments if m.provisional]
    assert len(alone) >= 15
    assert alone[-1].trust.why == ("fewer than 4 thermometers for 5 s", "no news of the drive")
    assert alone[-1].mode == Mode.INVALID
    assert [a.text for m in alone for a in m.begun] == ["nothing of the rig on the bus"]
    assert moments[-1].step.elongation_um == runs[0][-1].step.elongation_um
    assert "nothing of the rig on the bus" in {a.text for m in moments for a in m.over}


@pytest.mark.parametrize("ahead_s", [60.0, 3000.0, 1e5, 3.15e9, 5.7e9])
def test_after_a_stamp_that_is_ahead_a_silence_is_as_long_as_it_is(paper, frames, half_a_minute, ahead_s):
    """The frame whose stamp is in doubt is no news of the rig, and the model goes on from the one before."""
    last = next(f for f in reversed(frames) if f.id == DRIVE and since(frames, f) < 30)
    monitor = copied(half_a_minute, paper)
    silent = [*monitor.idle(1.0), *monitor.feed(last._replace(time_s=last.time_s + ahead_s))]
    heard_s = 0.0 if ahead_s > 2e9 else 1.0  # an absurd stamp is no life of the rig
    silent += [m for k in range(1, 60) for m in monitor.idle(1.0 - heard_s + 0.05 * k)]
    assert [int(m.step.time_s) for m in silent] == [30, 31, 32, 33]
    assert not monitor.trust(3.0).valid


def test_frames_with_absurd_stamps_do_not_keep_an_estimate_valid(paper, frames):
    monitor, clock = Monitor(paper[1], paper[0]), RigTime()
    late = [f._replace(time_s=5.7e9) for f in frames if 30 <= since(frames, f) < 32]
    for frame in [*(f for f in frames if since(frames, f) < 30), *late]:
        clock.place(frame)
        assert not any(m.provisional for m in monitor.feed(frame))
    assert monitor.trust(0.0).valid
    assert monitor.trust(2.0).why == ("no news of the drive",)
    assert clock.silence() > 0
    assert monitor.tally.counts()["time stamp absurd"] == len(late)
