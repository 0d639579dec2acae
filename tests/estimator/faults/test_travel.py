"""Position against speed: what a drive cannot do is said within a few ticks, what it does never."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.decode.condense import Condenser, Readings
from drivers.frames import Tally
from estimator.faults.travel import FELT_S, Travel, disagreements, too_slow
from estimator.record import Sample


def told(rig, position, omega) -> list[str]:
    travel, whys = Travel(rig), []
    for place, turns in zip(position, omega, strict=True):
        inputs = {"position": place, "speed": turns * 30 / np.pi}
        travel.step(Sample(0.0, np.empty(0), np.empty(0), inputs, turns, np.empty(0)))
        whys.append(travel.why)
    return whys


@pytest.fixture
def drive(rig):
    """Rest, strokes to and fro between 0 and 300 mm at 50 mm/s, rest: position and speed at each second."""
    time = np.arange(200.0)
    way = 50.0 * np.clip(time - 20.0, 0.0, 120.0)
    position = 300.0 - np.abs(300.0 - way % 600.0)
    speed = np.where((time > 20) & (time <= 140), 50.0, 0.0)
    return position, speed / (rig.the_screw().lead_mm / (2 * np.pi))


def test_strokes_and_gaps_are_right(rig, drive):
    position, omega = drive
    assert set(told(rig, position, omega)) == {""}
    position[50:52], position[10:20], omega[80:90] = np.nan, np.nan, np.nan
    assert set(told(rig, position, omega)) == {""}


def test_a_position_that_is_not_told_while_the_screw_turns_is_said_as_long_and_felt_for_minutes(rig, drive):
    position, omega = drive
    position[50:60] = np.nan
    whys = told(rig, position, omega)
    assert [k for k, why in enumerate(whys) if why] == [*range(52, 60)]
    assert whys[52] == "the position is not told though the screw turns"
    travel, lately = Travel(rig), []
    for k in range(300):
        inputs = {"position": np.nan if k < 5 else 0.0, "speed": 100.0 if k < 5 else 0.0}
        travel.step(Sample(float(k), np.empty(0), np.empty(0), inputs, 10.0 * (k < 5), np.empty(0)))
        lately.append(travel.lately)
    assert [k for k, why in enumerate(lately) if why] == [*range(2, 4 + int(FELT_S))]


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_of_the_tick_in_which_a_drive_begins_or_ends_the_speed_need_not_be_right(share, rig, drive):
    """On a bus sixty times as fast as the rig the frames of a tick have no time of their own."""
    position, omega = drive
    omega[[21, 140]] *= share
    assert set(told(rig, position, omega)) == {""}


@pytest.mark.parametrize("at", [10, 70, 170])
def test_a_shift_is_said_until_it_is_back(at, rig, drive):
    position, omega = drive
    position[at : at + 20] += 40.0
    whys = told(rig, position, omega)
    assert all(why.startswith("the position jumped by ") for why in whys[at : at + 20])
    assert set(whys[:at] + whys[at + 20 :]) == {""}


def test_a_position_that_stands_and_a_speed_that_is_dead(rig, drive):
    position, omega = drive
    stuck = np.where(np.arange(200) >= 60, position[60], position)
    assert told(rig, stuck, omega)[64] == "the position stands still though the speed says that the screw turns"
    assert told(rig, position, 0.0 * omega)[24] == "the position moves further than the speed says"
    running = np.where(np.arange(200) >= 100, omega[100], omega)
    assert told(rig, position, running)[145] == "the position stands still though the speed says that the screw turns"


def paced(rig, times, mm_s=40.0, signed=True, every=1, turns=1.0):
    """What is said at each tick of speeds ten a second, of a position, with every so many of them, that moves so many
    times as far from 200 s to 400 s, and of a speed that is so many times as high."""
    position, speed = strokes(mm_s, 0.1, 3)
    moved = np.diff(position, prepend=position[0])
    moved[2000:4000] *= times
    speed[2000:4000] *= turns
    now = 0.1 * np.arange(len(position))
    row, rpm = (now + 0.05).astype(int), speed / rig.the_screw().lead_mm * 60.0
    read = {"position": np.cumsum(moved), "speed": rpm if signed else abs(rpm)}
    frame, some = np.arange(len(now)), {"position": slice(None, None, every), "speed": slice(None)}
    told = {name: Readings(frame, row, now, value).where(some[name]) for name, value in read.items()}
    run = Condenser(rig, Tally()).rows(told, np.arange(row[-1] + 1.0))
    travel, whys, astray = Travel(rig), [], []
    for sample in run:
        travel.step(sample)
        whys.append(travel.why)
        astray.append(travel.astray)
    return whys, astray


@pytest.mark.parametrize("times", [1 / 25.4, 1 / 1.3, 0.8, 1.3])
def test_a_scale_that_is_wrong_is_said_within_seconds_until_it_is_right_and_heat_stays_astray(times, rig):
    whys, astray = paced(rig, times)
    said = [k for k, why in enumerate(whys) if why]
    assert 200 < said[0] < 210
    assert whys[said[-1]].endswith("times as far as the speed says: check units, scales and lead_mm")
    assert {why.split()[3] for why in whys if why.endswith("lead_mm")} == {f"{times:.2g}"}
    assert 400 <= said[-1] < 410
    assert astray.index(True) == said[0]
    assert all(astray[said[0] :])


@pytest.mark.parametrize("mm_s", [40.0, 330.0])
@pytest.mark.parametrize("signed", [True, False])
@pytest.mark.parametrize("every", [1, 2])
def test_the_pace_of_a_drive_that_turns_often_is_right(mm_s, signed, every, rig):
    assert not any(why.endswith("lead_mm") for why in paced(rig, 1.0, mm_s, signed, every)[0])


def test_a_speed_without_a_sign_still_tells_of_inches(rig):
    assert any(why.endswith("lead_mm") for why in paced(rig, 1 / 25.4, signed=False)[0])


@pytest.mark.parametrize("mm_s", [6.0, 40.0, 330.0])
def test_a_speed_that_is_dead_is_said_however_often_the_table_turns(mm_s, rig):
    whys, _ = paced(rig, 1.0, mm_s, turns=0.0)
    said = [k for k, why in enumerate(whys) if why == "the position moves though the speed says that the screw stands"]
    assert 200 < said[0] < 215
    assert 395 < said[-1] < 410
    assert "" not in whys[said[0] : said[-1]]


RAMP_MM_S2 = 2000.0


def strokes(mm_s, row_s, seed):
    """Position, mm, and speed, mm/s, at each row: rest, strokes of 50 .. 600 mm with dwells of 0 .. 3 s, rest."""
    dice, step_s = np.random.default_rng(seed), 0.01
    at, speeds = 0.0, [np.zeros(int(60 / step_s))]
    while sum(map(len, speeds)) * step_s < 900.0:
        to = dice.uniform(0.0, 600.0)
        ramp_s, way = mm_s / RAMP_MM_S2, abs(to - at)
        run_s = max(0.0, way / mm_s - ramp_s)
        time = np.arange(0.0, run_s + 2 * ramp_s, step_s)
        shape = np.minimum(1.0, np.minimum(time, run_s + 2 * ramp_s - time) / ramp_s)
        own = np.sign(to - at) * shape * way / (shape.sum() * step_s)
        speeds += [own, np.zeros(int(dice.uniform(0.0, 3.0) / step_s))]
        at = to
    speed = np.concatenate([*speeds, np.zeros(int(60 / step_s))])
    rows = np.arange(0, len(speed), int(row_s / step_s))
    return (np.cumsum(speed) * step_s)[rows], speed[rows]


def logged(rig, position, speed, row_s):
    """The recording of such rows, as a table of a lab is read: what came last holds until the next row."""
    each = round(row_s / rig.tick_s)
    now, row = row_s * np.arange(len(position)), each * np.arange(len(position))
    rpm = speed / rig.the_screw().lead_mm * 60.0
    read = {"position": Readings(row, row, now, position), "speed": Readings(row, row, now, rpm)}
    found = Condenser(rig, Tally(), max(2, 2 * each)).rows(read, rig.tick_s * np.arange(each * len(position)))
    held = {name: found.inputs[name][np.arange(len(found)) // each * each] for name in read}
    return replace(found, inputs={**found.inputs, **held})


@pytest.mark.parametrize("tick_s", [1.0, None])
@pytest.mark.parametrize("row_s", [1.0, 2.0, 5.0, 10.0])
@pytest.mark.parametrize("mm_s", [40.0, 330.0])
def test_rows_between_which_an_axis_starts_stops_and_turns_are_right(mm_s, row_s, tick_s, rig):
    own = replace(rig, tick_s=tick_s or row_s)
    for seed in range(3):
        run = logged(own, *strokes(mm_s, row_s, seed), row_s)
        assert list(disagreements(run, own)) == []
        assert f"speeds {row_s:g} s apart are too slow to check the position" in too_slow(run, own)


def test_rows_faster_than_ticks_are_not_too_slow(rig):
    own = replace(rig, tick_s=5.0)
    position, speed = strokes(40.0, 1.0, 0)
    now, row = np.arange(len(position)) * 1.0, np.arange(len(position)) // 5
    read = {name: Readings(row, row, now, value) for name, value in (("position", position), ("speed", speed * 5.0))}
    assert too_slow(Condenser(own, Tally()).rows(read, 5.0 * np.arange(row[-1] + 1)), own) == ""


def test_a_shift_that_no_axis_makes_between_two_rows_is_said_and_a_shorter_one_is_not(rig):
    position, speed = strokes(40.0, 1.0, 1)
    at, way = 400, 1.1 * np.abs(speed).max() + 5.0
    for shift, said in ((2.0 * way, True), (0.0, False)):
        run = logged(rig, position + np.where(np.arange(len(position)) >= at, shift, 0.0), speed, 1.0)
        whys = list(disagreements(run, rig))
        assert [(time_s, why[:22]) for time_s, why in whys] == ([(at, "the position jumped by")] if said else [])


def test_a_shift_of_40_mm_along_the_motion_is_said_of_slow_rows_too(rig):
    position, speed = strokes(40.0, 1.0, 1)
    along = np.flatnonzero((speed[1:-1] > 39.0) & (speed[2:] > 39.0) & (np.arange(len(speed) - 2) > 300))[0] + 2
    run = logged(rig, position + np.where(np.arange(len(position)) >= along, 40.0, 0.0), speed, 1.0)
    assert [time_s for time_s, _ in disagreements(run, rig)] == [along]


@pytest.mark.parametrize("row_s", [1.0, 10.0])
def test_a_shift_at_rest_is_told_for_what_is_known_of_it(row_s, rig):
    """A jump, or a move between two readings: until it is back, or the screw turns."""
    position, speed = strokes(330.0, row_s, 3)
    position, speed = np.append(position, np.full(60, position[-1])), np.append(speed, np.zeros(60))
    shifted = np.arange(len(position)) >= len(position) - 40
    told = [why for _, why in disagreements(logged(rig, position + 40.0 * shifted, speed, row_s), rig)]
    assert told == ["the position moved by +40.0 mm though the screw stood at every reading"]
    back = shifted & (np.arange(len(position)) < len(position) - 20)
    travel = Travel(rig)
    for sample in logged(rig, position + 40.0 * back, speed, row_s):
        travel.step(sample)
    assert travel.why == ""


def test_slow_rows_tell_of_a_speed_that_is_dead(rig):
    position, speed = strokes(40.0, 2.0, 2)
    told = list(disagreements(logged(rig, position, 0.0 * speed, 2.0), rig))
    assert [why for _, why in told][:1] == ["the position moves though the speed says that the screw stands"]
    assert told[0][0] < 150


def test_slow_rows_tell_of_a_position_that_stands(rig):
    position, speed = strokes(40.0, 2.0, 2)
    later = np.arange(len(position)) >= 200
    stuck = logged(rig, np.where(later, position[200], position), speed, 2.0)
    assert [why[:26] for _, why in disagreements(stuck, rig)][-1] == "the position stands still "


def test_a_drive_that_sends_seldom_at_rest_is_checked_there(rig):
    """Frames each 0.1 s while it turns, each second at rest: a shift of 40 mm at rest is one."""
    position, speed = strokes(330.0, 0.1, 3)
    sent = (speed != 0.0) | (np.arange(len(speed)) % 10 == 0)
    shifted = position + np.where(np.arange(len(position)) >= len(position) - 300, 40.0, 0.0)
    now, row = 0.1 * np.flatnonzero(sent), np.flatnonzero(sent) // 10
    rpm = speed / rig.the_screw().lead_mm * 60.0
    for place, said in ((position, []), (shifted, ["the position jumped by +40.0 mm"])):
        read = {name: Readings(row, row, now, value[sent]) for name, value in (("position", place), ("speed", rpm))}
        run = Condenser(rig, Tally()).rows(read, np.arange(row[-1] + 1.0))
        assert [why for _, why in disagreements(run, rig)] == said


def framed(rig, change, every=1):
    """What is said at each tick of a drive of 330 mm/s that sends each 10 ms, of a position that `change` has made
    another one, read with every so many of the speeds."""
    position, speed = strokes(330.0, 0.01, 3)
    now, rpm = 0.01 * np.arange(len(position)), speed / rig.the_screw().lead_mm * 60.0
    frame, row, some = np.arange(len(now)), (now + 0.005).astype(int), slice(None, None, every)
    read = {
        "position": Readings(frame, row, now, change(position, now)).where(some),
        "speed": Readings(frame, row, now, rpm),
    }
    return list(disagreements(Condenser(rig, Tally()).rows(read, np.arange(row[-1] + 1.0)), rig))


@pytest.mark.parametrize("every", [1, 5])
def test_a_position_that_is_told_more_seldom_than_the_speed_does_not_jump(every, rig):
    assert framed(rig, lambda position, _: position, every) == []


@pytest.mark.parametrize("at_s", [200.0, 200.31, 203.0, 207.77])
def test_a_shift_shorter_than_the_way_of_a_tick_is_said_within_a_second(at_s, rig):
    ((said_s, why),) = framed(rig, lambda position, now: position + np.where(now >= at_s, 40.0, 0.0))
    assert 0.0 <= said_s - int(at_s) <= 1.0
    assert why.startswith(("the position jumped by +39", "the position jumped by +40"))


def test_a_shift_between_two_frames_that_is_back_is_over(rig):
    travel, whys = Travel(rig), []
    for slip_mm in (0.0, 40.0, 0.0, -39.6, 0.0):
        inputs = {"position": 0.0, "speed": 0.0}
        travel.step(Sample(0.0, np.empty(0), np.empty(0), inputs, 0.0, np.empty(0), slip_mm=slip_mm))
        whys.append(travel.why)
    assert whys == ["", *["the position jumped by +40.0 mm"] * 2, "", ""]


def test_a_position_that_runs_the_other_way_from_its_own_place_on_is_said(rig):
    def turned(position, now):
        return np.where(now < 200.0, position, 2.0 * position[20000] - position)

    said_s, why = framed(rig, turned)[0]
    assert why == "the position moves the other way than before"
    assert said_s < 215.0


def test_heat_is_astray_while_nothing_is_heard_of_the_drive_and_as_long_again(rig):
    travel, astray = Travel(rig), []
    for k in range(100):
        inputs = dict.fromkeys(("position", "speed"), np.nan if 20 <= k < 50 else 0.0)
        travel.step(Sample(float(k), np.empty(0), np.empty(0), inputs, inputs["speed"], np.empty(0)))
        astray.append(travel.astray)
    assert [k for k, so in enumerate(astray) if so] == [*range(20, 79)]
