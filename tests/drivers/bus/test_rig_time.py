"""The rig's time on a bus that runs faster: by the scans, not by stamps that a busy machine gives late."""

import numpy as np
import pytest

from drivers.bus.rig_time import FastTime, RigTime
from drivers.received import Received
from tests.live_fake import DRIVE, STATUS, Frames, rig_frames

SPEED_UP = 60.0
START_S = 1_790_000_000.0


def closing(frame: Received) -> int | None:
    return int.from_bytes(frame.data[2:4], "little") if frame.id == STATUS else None


@pytest.fixture(scope="module")
def frames() -> Frames:
    return rig_frames(120.0)


def hurried(frames: Frames, jitter_s: float) -> Frames:
    """Stamped as they come off a bus sixty times as fast, each up to `jitter_s` late, never before the one before."""
    dice = np.random.default_rng(3)
    wall = np.array([(f.time_s - frames[0].time_s) / SPEED_UP for f in frames])
    late = np.maximum.accumulate(wall + jitter_s * dice.random(len(wall)) * (dice.random(len(wall)) < 0.01))
    return [f._replace(time_s=START_S + t) for f, t in zip(frames, late.tolist(), strict=True)]


def placed(clock: RigTime, frames: Frames) -> Frames:
    return [*(each for frame in frames for each in clock.place(frame)), *clock.flush()]


def test_at_the_rigs_pace_frames_keep_their_stamps(frames):
    clock = RigTime()
    assert clock.silence() == 0.0
    assert placed(clock, frames) == frames
    assert 0.0 < clock.silence() < 60.0


@pytest.mark.parametrize("jitter_s", [0.0, 0.05, 0.3])
def test_faster_every_scan_lasts_one_tick_however_late_its_frames(frames, jitter_s):
    found = placed(FastTime(SPEED_UP, 1.0, closing, 65536), hurried(frames, jitter_s))
    assert [f[1:] for f in found] == [f[1:] for f in frames]
    times = np.array([f.time_s for f in found])
    assert (np.diff(times) > 0).all()
    scans = times[[f.id == STATUS for f in found]]
    np.testing.assert_allclose(np.diff(scans), 1.0, atol=2e-6)
    true = np.array([f.time_s for f in frames])
    drift = (times - times[0]) - (true - true[0])
    assert np.abs(drift - drift.mean()).max() < 1.0
    assert times[0] == pytest.approx(START_S, abs=1.0)


@pytest.mark.parametrize("tick_s", [0.5, 5.0])
def test_faster_a_scan_lasts_a_tick_of_any_length(frames, tick_s):
    slower = [f._replace(time_s=START_S + (f.time_s - START_S) * tick_s) for f in hurried(frames, 0.05 / tick_s)]
    found = placed(FastTime(SPEED_UP, tick_s, closing, 65536), slower)
    np.testing.assert_allclose(np.diff([f.time_s for f in found if f.id == STATUS]), tick_s, atol=2e-6)


def test_the_patience_with_a_scan_is_counted_in_ticks(frames):
    """Ticks of 5 s on a bus twice as fast: after 6.25 s of wall time without an end the stamps serve."""
    drive = next(f for f in frames if f.id == DRIVE)
    clock = FastTime(2.0, 5.0, closing, 65536)
    assert not [g for s in (0.0, 3.0, 6.0) for g in clock.place(drive._replace(time_s=START_S + s))]
    assert len(clock.place(drive._replace(time_s=START_S + 6.5))) == 4


@pytest.mark.parametrize("modulus", [15, 16, 256])
def test_a_narrow_number_of_scans_starts_again(frames, modulus):
    """Ten scans are lost while it does."""
    first = closing(next(f for f in frames if f.id == STATUS))
    heard = [f for f in frames if not 8 <= f.time_s - frames[0].time_s < 18]

    def counted(frame: Received) -> int | None:
        number = closing(frame)
        return None if number is None else (number - first + modulus - 10) % modulus

    found = placed(FastTime(SPEED_UP, 1.0, counted, modulus), hurried(heard, 0.0))
    scans = [f.time_s for f in found if f.id == STATUS]
    assert max(np.diff(scans)) == pytest.approx(11.0, abs=0.01)
    assert scans[-1] - scans[0] == pytest.approx(120.0, abs=0.01)


def test_lost_scans_take_their_time(frames):
    heard = [f for f in frames if not 30 <= f.time_s - frames[0].time_s < 50]
    found = placed(FastTime(SPEED_UP, 1.0, closing, 65536), hurried(heard, 0.0))
    scans = [f.time_s for f in found if f.id == STATUS]
    assert max(np.diff(scans)) == pytest.approx(21.0, abs=0.01)
    true = [f.time_s for f in heard if f.id == STATUS]
    assert scans[-1] - scans[0] == pytest.approx(true[-1] - true[0], abs=0.01)


def test_without_scans_the_stamps_serve(frames):
    heard = [f for f in frames if f.id != STATUS]
    found = placed(FastTime(SPEED_UP, 1.0, closing, 65536), hurried(heard, 0.0))
    assert found[-1].time_s - found[0].time_s == pytest.approx(120.0, abs=3.0)


@pytest.mark.parametrize("tick_s", [0.5, 1.0, 5.0])
def test_a_rig_started_again_goes_on_one_tick_later(frames, tick_s):
    first, again = hurried(frames, 0.0), hurried(frames, 0.0)
    again = [f._replace(time_s=f.time_s + 2.1) for f in again]
    found = placed(FastTime(SPEED_UP, tick_s, closing, 65536), [*first, *again])
    steps = np.diff([f.time_s for f in found if f.id == STATUS])
    np.testing.assert_allclose(steps, tick_s, atol=2e-6)


def test_a_pause_in_mid_scan_is_no_time_of_the_rig(frames):
    """The next scan tells how many ticks it was: one, for a rig that was stopped."""
    before = hurried(frames, 0.0)
    middle = next(k for k, f in enumerate(frames) if k > 3000 and f.id == DRIVE)
    paused = [f._replace(time_s=f.time_s + (5.0 if k >= middle else 0.0)) for k, f in enumerate(before)]
    found = placed(FastTime(SPEED_UP, 1.0, closing, 65536), paused)
    scans = [f.time_s for f in found if f.id == STATUS]
    assert max(np.diff(scans)) == pytest.approx(1.0, abs=0.1)
    assert (np.diff([f.time_s for f in found]) >= 0).all()


@pytest.mark.parametrize("tick_s", [0.1, 1.0, 10.0])
def test_a_wrong_speed_up_is_told(frames, tick_s):
    slow = [f._replace(time_s=START_S + tick_s * (f.time_s - frames[0].time_s)) for f in frames]
    clock = FastTime(SPEED_UP, tick_s, closing, 65536)
    placed(clock, slow)
    assert "--speed-up 60" in clock.trouble
    right = FastTime(SPEED_UP, tick_s, closing, 65536)
    in_time = hurried(frames, 0.05 / max(tick_s, 1.0))
    placed(right, [f._replace(time_s=START_S + tick_s * (f.time_s - START_S)) for f in in_time])
    assert not right.trouble


def test_error_frames_absurd_stamps_and_our_own_are_no_life(frames):
    clock = RigTime({(0x610, False)})
    clock.place(frames[0])
    silent = clock.silence()
    clock.place(frames[0]._replace(kind="error"))
    clock.place(frames[0]._replace(id=0x610))
    clock.place(frames[0]._replace(time_s=5.7e9))
    assert clock.silence() > silent


def test_what_is_overdue_is_placed_while_the_bus_is_silent(frames, monkeypatch):
    clock = FastTime(SPEED_UP, 1.0, closing, 65536)
    assert not [f for frame in hurried(frames, 0.0)[:5] for f in clock.place(frame)]
    assert not clock.overdue()
    monkeypatch.setattr(clock, "_patience_s", -1.0)
    assert len(clock.overdue()) == 5


def test_what_we_send_ourselves_neither_waits_nor_counts(frames):
    clock = FastTime(SPEED_UP, 1.0, closing, 65536, {(0x610, False)})
    ours = Received(START_S, 0x610, False, bytes(8))
    mixed = [g for f in hurried(frames, 0.0) for g in (f, ours._replace(time_s=f.time_s))]
    found = placed(clock, mixed)
    assert len(found) == 2 * len(frames)
    rigs = [f for f in found if f.id != 0x610]
    assert rigs == placed(FastTime(SPEED_UP, 1.0, closing, 65536), hurried(frames, 0.0))


@pytest.mark.parametrize("ahead_s", [60.0, 3000.0, 2e9, 5.7e9])
@pytest.mark.parametrize("scans", [True, False])
def test_a_stamp_that_is_ahead_moves_no_clock_and_holds_up_nothing(frames, ahead_s, scans, monkeypatch):
    """But by 50 ms of the bus, which are 3 s of the rig."""
    monkeypatch.setattr("drivers.bus.rig_time.time.monotonic", lambda: 0.0)  # however busy the machine is
    rows = [f for f in hurried(frames, 0.0) if scans or f.id != STATUS]
    for k in (0, 1, 1500, 3000):
        rows[k] = rows[k]._replace(time_s=rows[k].time_s + ahead_s)
    clock = FastTime(SPEED_UP, 1.0, closing, 65536)
    placed_, most = [], 0
    for row in rows:
        placed_ += clock.place(row)
        most = max(most, len(clock._waiting))
    placed_ += clock.flush()
    assert len(placed_) == len(rows)
    assert most < 0.6 * SPEED_UP * 120
    sound = [f.time_s for f in placed_ if f.time_s < 4.2e9]
    assert len(sound) >= len(rows) - 4
    assert (np.diff(sound) >= 0).all()
    assert sound[-1] - sound[0] == pytest.approx(120.0, abs=4 * 3.0)
