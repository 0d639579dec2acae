"""The monitor and every fault that a bus and its sensors can have: what it says, and what it goes on to estimate."""

import copy
import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ballscrew.monitor import monitor as monitoring
from ballscrew.monitor.monitor import Moment, Monitor
from drivers.decode.checks import frame_checksum
from drivers.received import Received
from drivers.recordings import read_recording
from drivers.virtual_rig import simulate, write
from estimator.batch.replay import replay
from estimator.screw import Bed
from estimator.step import Mode
from tests.live_fake import DRIVE, STATUS, TELEMETERS, Frames, changed, channel, dropped, since

ENVIRONMENT = 0x240
FAULT_S, SOON_S, END_S = 119.0, 145.0, 175.0  # the fault is there for half a minute, or a whole window of the tests

Run = Callable[[Frames], tuple[Monitor, list[Moment]]]


@pytest.fixture(scope="module")
def run(paper, frames) -> Run:
    """run(frames): all of them, those before the fault from a monitor that has lived them once."""
    rig, model = paper
    before, sound = Monitor(model, rig), [f for f in frames if since(frames, f) < FAULT_S - 1]
    lived = [moment for frame in sound for moment in before.feed(frame)]

    def of(frames: Frames) -> tuple[Monitor, list[Moment]]:
        monitor = copied(before, paper)
        moments = [moment for frame in frames[len(sound) :] for moment in monitor.feed(frame)]
        return monitor, [*lived, *moments, *monitor.finish()]

    return of


@pytest.fixture(scope="module")
def plain(run, frames) -> list[Moment]:
    """The run without a fault."""
    monitor, moments = run(frames)
    assert not any(moment.begun for moment in moments)
    assert not monitor.active
    return moments


@pytest.fixture(scope="module")
def soon(frames) -> Frames:
    """The frames up to half a minute after the fault."""
    return [f for f in frames if since(frames, f) < SOON_S]


def copied(monitor: Monitor, paper) -> Monitor:
    return copy.deepcopy(monitor, {id(each): each for each in paper})


def begun(moments: list[Moment]) -> str:
    return "\n".join(alarm.text for moment in moments for alarm in moment.begun)


def apart_sd(moments: list[Moment], plain: list[Moment]) -> float:
    """How far the last estimate is from that without the fault, in its own sd."""
    last = moments[-1].step
    there = min((moment.step for moment in plain), key=lambda step: abs(step.time_s - last.time_s))
    assert last.time_s == pytest.approx(there.time_s, abs=1.5)
    return abs(last.elongation_um - there.elongation_um) / last.sigma_um


def thermometer(number: int, raw: Callable[[int, float], int]) -> Callable[[Frames], Frames]:
    can_id, change = channel(number, raw)
    return lambda frames: changed(frames, can_id, FAULT_S, change)


def spike(value: int, time_s: float) -> int:
    return value + 2000 if round(time_s) % 10 == 0 else value


def test_live_is_review(rig, shipped, plain, tmp_path):
    """Frame by frame the same estimates as from a log of the same frames."""
    log = write(simulate("FS-20", seed=7, seconds=END_S), tmp_path / "a.log")
    track = replay(shipped, rig, read_recording(log, rig))
    live = np.array([[m.step.elongation_um, m.step.sigma_um, m.step.error_at_table_um] for m in plain])
    assert len(live) == len(track)
    batch = np.stack([track.elongation_um, track.sigma_um, track.error_at_table_um], axis=-1)
    np.testing.assert_allclose(live[1:], batch[1:], atol=1e-9)


HARMLESS = {
    "a message missing": (lambda f: dropped(f, FAULT_S, [0x211]), r"Telemeter2 \(0x211\) is missing"),
    "spikes": (thermometer(5, spike), "T05 at 415 mm is loose"),
}


@pytest.mark.parametrize("name", HARMLESS)
def test_a_fault_of_some_channels_is_told_and_the_rest_serve(run, frames, plain, name):
    fault, says = HARMLESS[name]
    _, moments = run(fault(frames))
    assert re.search(says, begun(moments))
    assert moments[-1].trust.valid
    assert apart_sd(moments, plain) < 3


def test_thermometers_dead_broken_and_out_of_range_are_told_and_the_rest_serve(run, soon, plain):
    broken = soon
    for number, raw in ((5, -32768), (9, -32767), (12, 32000)):
        broken = thermometer(number, lambda v, t, raw=raw: raw)(broken)
    _, moments = run(broken)
    for says in ("T05 at 415 mm", "T09 at 817 mm", "T12 at 889 mm"):
        assert f"{says} is not read" in begun(moments)
    assert moments[-1].trust.valid
    assert apart_sd(moments, plain) < 3


def test_a_stuck_thermometer_is_named_with_its_place_and_since_when(run, frames, plain):
    _, moments = run(thermometer(5, lambda v, t: 2345)(frames))
    (alarm,) = (a for m in moments for a in m.begun if a.kind == "stuck")
    assert alarm.text == "T05 at 415 mm is stuck at 23.45 degC"
    assert alarm.since_s == pytest.approx(FAULT_S, abs=2)
    assert moments[-1].trust.valid
    assert apart_sd(moments, plain) < 3


def test_an_offset_is_named_and_left_out_also_when_it_has_just_passed(run, frames, plain):
    _, moments = run(thermometer(5, lambda v, t: v + 200 if t < 160 else v)(frames))
    (alarm,) = (a for m in moments for a in m.begun if a.channel == "T05")
    assert (alarm.kind, alarm.text) == ("jumped", "T05 at 415 mm has jumped")
    assert alarm.since_s == pytest.approx(121, abs=2)
    assert not moments[-1].step.fused[4]  # it came back a quarter of a minute ago
    assert all(m.trust.valid for m in moments[5:])
    assert apart_sd(moments, plain) < 3


def test_a_silent_telemeter_makes_the_estimate_invalid_and_its_return_valid(run, soon, plain):
    gone = dropped(soon, FAULT_S, [*TELEMETERS, STATUS], FAULT_S + 20)
    _, moments = run(gone)
    modes = {round(m.step.time_s): m.mode for m in moments}
    assert modes[round(FAULT_S) + 3] in (Mode.COASTING, Mode.UPDATE)
    assert modes[round(FAULT_S) + 12] == Mode.INVALID
    silent = next(m for m in moments if m.mode == Mode.INVALID)
    assert silent.trust.why == ("fewer than 4 thermometers for 5 s",)
    assert silent.trust.telemeter_stale
    assert moments[-1].trust.valid
    assert "no thermometer is read" in begun(moments)
    assert "no thermometer is read" in {a.text for m in moments for a in m.over}
    assert apart_sd(moments, plain) < 3


def test_why_there_is_no_error_at_the_table_is_told_once(paper, frames, monkeypatch):
    monkeypatch.setattr(monitoring, "PATIENCE_S", 10.0)
    rig, said = replace(paper[0], bed=Bed("base")), {}
    for name, some in (("read", frames), ("never", dropped(frames, 0.0, [ENVIRONMENT]))):
        monitor, said[name] = Monitor(paper[1], rig), []
        for frame in [f for f in some if since(frames, f) < 20.0]:
            moments = list(monitor.feed(frame))
            said[name] += [note for note in monitor.tally.notes if "bed" in note]
            monitor.tally.notes.clear()
        assert np.isfinite(moments[-1].step.error_at_table_um) == (name == "read")
    assert said["read"] == []
    assert len(said["never"]) == 1
    assert "inputs.base in rig.toml" in said["never"][0]


def test_a_silent_drive_is_told_at_once(run, soon):
    _, moments = run(dropped(soon, FAULT_S, [DRIVE], FAULT_S + 10))
    first = next(m for m in moments if m.mode == Mode.INVALID)
    assert first.step.time_s < FAULT_S + 3.1
    assert first.trust.why == ("no news of the drive",)
    assert "Drive (0x230) is missing" in begun(moments)


def wrong(can_id: int, byte: int) -> Callable[[Frames], Frames]:
    def change(frame: Received) -> Received:
        data = bytearray(frame.data)
        data[byte] ^= 0x15
        return frame._replace(data=bytes(data))

    return lambda frames: [
        change(f) if f.id == can_id and FAULT_S <= since(frames, f) < FAULT_S + 8 else f for f in frames
    ]


@pytest.mark.parametrize(
    ("fault", "reason"),
    [(wrong(STATUS, 0), "checksum wrong TelemeterStatus"), (wrong(0x241, 7), r"lost Environment2 \(by its counter\)"),
     (wrong(0x211, 3), "scan")],
    ids=["checksum", "counter", "scan checksum"],
)  # fmt: skip
def test_what_is_not_used_is_counted(run, soon, plain, fault, reason):
    monitor, moments = run(fault(soon))
    assert any(re.match(reason, each) for each in monitor.tally.counts()), monitor.tally.counts()
    assert moments[-1].trust.valid
    assert apart_sd(moments, plain) < 3


@pytest.mark.parametrize("jump_s", [-4000.0, 500.0, 1e6])
def test_a_jump_of_the_clock_costs_nothing(run, soon, plain, jump_s):
    moved = [f._replace(time_s=f.time_s + (jump_s if since(soon, f) > FAULT_S else 0.0)) for f in soon]
    monitor, moments = run(moved)
    assert [m.step.time_s for m in moments[-20:]] == [m.step.time_s for m in plain][len(moments) - 20 : len(moments)]
    assert apart_sd(moments, plain) < 0.1
    assert any("clock jumps" in note for note in monitor.tally.notes)
    assert moments[-1].trust.valid


def test_frames_out_of_order_cost_nothing(run, soon, plain):
    swapped = list(soon)
    for k in range(int(0.7 * len(swapped)), len(swapped) - 1, 20):
        swapped[k], swapped[k + 1] = swapped[k + 1], swapped[k]
    monitor, moments = run(swapped)
    assert apart_sd(moments, plain) < 0.1
    assert monitor.tally.counts()["time stamp before the last one (used)"] > 10


def test_after_a_night_the_estimate_begins_anew(run, frames, plain):
    tomorrow = [f._replace(time_s=f.time_s + 8 * 3600) for f in frames]
    later = [f for f in tomorrow if since(frames, f) > 8 * 3600 + 145]
    scans = [_with_scan(f, 30_000) for f in later]
    monitor, moments = run([*frames, *scans])
    assert "the estimate begins anew" in monitor.tally.notes
    assert moments[len(plain) - 1].step.elongation_um == plain[-1].step.elongation_um
    assert moments[len(plain) + 5].step.time_s == pytest.approx(6, abs=2)
    assert abs(moments[len(plain)].step.elongation_um) < 0.5
    assert moments[-1].trust.valid
    assert "after the end of the recording" not in monitor.tally.counts()


def test_a_drive_that_stops_is_not_a_drive_that_is_gone(run, soon):
    """At rest it is heard each second only, from the instant of the stop on."""
    rests, last = [], 0.0
    for frame in soon:
        at = since(soon, frame)
        if frame.id != DRIVE or at < FAULT_S or at - last > 0.995:
            rests.append(frame)
            last = at if frame.id == DRIVE else last
    _, moments = run(rests)
    assert not any("no news of the drive" in m.trust.why for m in moments if m.step.time_s > 5)


def test_a_tick_without_a_drive_frame_keeps_its_place(run, soon):
    gone = [f for f in soon if not (f.id == DRIVE and FAULT_S + 2 < since(soon, f) < FAULT_S + 3.2)]
    _, moments = run(gone)
    assert all(np.isfinite(m.step.error_at_table_um) for m in moments)
    assert all(np.isfinite(m.step.position_mm) for m in moments)


def test_with_few_thermometers_chosen_few_are_enough(rig, shipped, frames):
    mask = np.array([name not in ("T05", "T12", "displacement") for name in rig.names])
    monitor = Monitor(shipped, rig, lambda time_s: mask)
    moments = [m for frame in frames if since(frames, frame) < 30 for m in monitor.feed(frame)]
    assert moments[-1].trust.valid
    assert not moments[-1].trust.telemeter_stale


def _with_scan(frame: Received, later: int) -> Received:
    if frame.id != STATUS:
        return frame
    data = bytearray(frame.data)
    data[2:4] = ((int.from_bytes(data[2:4], "little") + later) % 65536).to_bytes(2, "little")
    data[0] = int(frame_checksum(STATUS, np.array([data], np.uint8))[0])
    return frame._replace(data=bytes(data))


def test_frames_of_ours_and_error_frames_are_not_the_rigs(run, soon, plain):
    """They say nothing of the rig: not even that its clock goes on."""
    late = [f for f in soon if since(soon, f) >= FAULT_S]
    ours = [g for f in late for g in (f, f._replace(id=0x610, data=bytes(8)), f._replace(kind="error", id=4))]
    monitor, moments = run([*soon[: -len(late)], *ours])
    assert moments[-1].step.elongation_um == plain[len(moments) - 1].step.elongation_um
    assert monitor.tally.counts()["sent by us"] == len(late)
    assert monitor.tally.counts()["error frame"] == len(late)
