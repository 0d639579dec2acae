"""A monitor that is started again goes on where the one before ended, and the zero is not lost."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ballscrew.monitor.monitor import Moment, Monitor
from ballscrew.monitor.resume import resume
from drivers.recorder.recorder import Recorder
from drivers.recordings import read_joined
from estimator.batch.replay import replay
from tests.ballscrew.monitor.test_left_out import sent
from tests.live_fake import Frames, lived, since

END_S = 130.0
AFTER_S = 30.0  # that a monitor is followed for once it has been started again


@pytest.fixture(scope="module")
def through(rig, shipped, frames) -> list[Moment]:
    """The run without a restart."""
    return lived(Monitor(shipped, rig), frames)


def recorded(folder: Path, frames: Frames) -> Path:
    with Recorder(folder, {}) as recorder:
        for frame in frames:
            recorder.write(frame)
        return recorder.path


def restarted(paper, frames: Frames, folder: Path, at_s: float, gap_s: float) -> tuple[Monitor, list[Moment], str]:
    """A monitor that begins `gap_s` after the first one ended."""
    rig, model = paper
    part = recorded(folder, [frame for frame in frames if since(frames, frame) < at_s])
    monitor = Monitor(model, rig)
    sentence = resume(monitor, [part], lambda: True)
    after = [frame for frame in frames if at_s + gap_s <= since(frames, frame) < at_s + gap_s + AFTER_S]
    recorded(folder, after)
    return monitor, lived(monitor, after), sentence


@pytest.mark.parametrize(("at_s", "gap_s"), [(40.0, 0.4), (60.7, 25.0)])
def test_the_elongation_goes_on(paper, frames, through, tmp_path, at_s, gap_s):
    """In the drive, with the machine going on while nobody listens; the same as by the parts joined."""
    monitor, moments, sentence = restarted(paper, frames, tmp_path, at_s, gap_s)
    assert monitor.resumed_s == pytest.approx(at_s, abs=1.5)
    assert sentence.startswith("goes on with ")
    assert moments[0].step.time_s == pytest.approx(at_s + 1.0, abs=1.6)
    usual = {round(moment.step.time_s): moment.step.elongation_um for moment in through}
    for moment in moments:
        if moment.step.time_s > at_s + gap_s + 2:
            apart = abs(moment.step.elongation_um - usual[round(moment.step.time_s)])
            assert apart < 0.2 + 2 * moment.step.sigma_um
    rig, model = paper
    _, joined = read_joined(sorted(tmp_path.glob("*.log")), rig)
    track = replay(model, rig, joined)
    assert moments[-1].step.elongation_um == pytest.approx(track.elongation_um[-1], abs=1e-9)


def test_what_was_told_then_is_not_told_again(paper, frames, tmp_path):
    silent = [frame for frame in frames if frame.id != 0x211 or not 30 < since(frames, frame) < 40]
    odd = [frame._replace(id=0x7) if 10 < since(frames, frame) < 20 else frame for frame in silent]
    monitor, moments, _ = restarted(paper, odd, tmp_path, 60.0, 1.0)
    assert not any(alarm.since_s < 60.0 for moment in moments for alarm in moment.begun)
    assert "unknown id" not in monitor.tally.counts()


def test_an_alarm_that_is_still_on_is_told(paper, frames, tmp_path):
    silent = [frame for frame in frames if frame.id != 0x211 or since(frames, frame) < 40]
    _, moments, _ = restarted(paper, silent, tmp_path, 60.0, 1.0)
    assert any("Telemeter2" in alarm.text for alarm in moments[0].begun)


def test_what_cannot_be_read_is_no_reason_not_to_start(rig, shipped, frames, through, tmp_path):
    monitor = Monitor(shipped, rig)
    foreign = recorded(tmp_path, [frame._replace(id=0x7) for frame in frames[:500]])
    assert resume(monitor, [foreign], lambda: True).startswith(
        f"cannot go on with {foreign.name}, and begins anew: no "
    )
    assert monitor.resumed_s is None
    moments = [moment for frame in frames if since(frames, frame) < 60.0 for moment in monitor.feed(frame)]
    assert len(moments) > 50
    assert moments[-1].step.elongation_um == through[len(moments) - 1].step.elongation_um


def test_the_end_is_not_waited_for(rig, shipped, frames, tmp_path):
    part, left = recorded(tmp_path, frames), iter([True] * 100 + [False])
    assert resume(Monitor(shipped, rig), [part], lambda: next(left)) == "stopped before the recording was read"


def test_a_silence_of_an_hour_ends_it(paper, frames, tmp_path):
    monitor, moments, _ = restarted(paper, frames, tmp_path, 60.0, 1.0)
    late = [frame._replace(time_s=frame.time_s + 5000.0) for frame in frames[:400]]
    anew = lived(monitor, late)
    assert monitor.resumed_s is None
    assert np.isfinite(anew[-1].step.elongation_um)
    assert anew[-1].step.time_s < moments[-1].step.time_s


def test_a_start_with_a_warm_screw_is_said_once_and_marked(rig, shipped, frames, tmp_path):
    late = [frame for frame in frames if since(frames, frame) > 100.0]
    monitor = Monitor(shipped, rig)
    moments = lived(monitor, late)
    assert [note for note in monitor.tally.notes if note.startswith("began warm: about ")] == [monitor.start.sentence]
    assert all(moment.trust.began_warm for moment in moments)
    _, compensation = sent(rig, moments[-1].step, moments[-1].trust)
    assert compensation["CmpBeganWarm"] == 1
    resume(again := Monitor(shipped, rig), [recorded(tmp_path, late)], lambda: True)
    assert again.start.sentence in again.tally.notes


def test_a_cold_screw_and_one_counted_from_a_zero_are_not_marked(rig, shipped, frames):
    assert not lived(Monitor(shipped, rig), frames[:500])[-1].trust.began_warm
    late = [frame for frame in frames if since(frames, frame) > 120.0]
    monitor = Monitor(shipped, replace(rig, zero_C=20.0))
    assert not lived(monitor, late)[-1].trust.began_warm
    assert monitor.start.warm
