"""Heat that the model lacks and a thermometer that drifts look alike, until the heat comes to the next ones."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from drivers.recordings import read_recording
from drivers.virtual_rig import simulate, write
from estimator.batch.replay import replay
from estimator.faults.beside.change import AS_IT_IS, Change
from estimator.faults.beside.local_heat import BEGINS, LATE, local_heats
from estimator.faults.fault import Fault
from estimator.filter import Filter
from tests.conftest import stepped

ONE, SECONDS = 4, 1200


def test_a_bar_is_warmed_as_its_green_function_says(paper):
    """T = 1 W / (rho c A) times the integral of exp(-x^2 / 4 a s) / sqrt(4 pi a s) over the time."""
    screw = paper[0].screw
    stores = screw.density * screw.heat_capacity
    a = screw.conductivity / stores
    for mm in (0.0, 60.0, -144.0):
        over = quad(lambda s, x=mm * 1e-3: np.exp(-(x**2) / (4 * a * s)) / np.sqrt(4 * np.pi * a * s), 0.0, 300.0)[0]
        assert screw.warmed(np.array([mm]), 300.0)[0] == pytest.approx(over / (stores * screw.area), rel=1e-6)


def change_of(rig, value, seconds):
    x_mm = np.array([rig.channels[name].at_mm for name in rig.thermometers])
    model = seconds / 120.0 * (0.01**2 * np.exp(-0.5 * ((x_mm[:, None] - x_mm) / 250.0) ** 2) + 0.003**2 * np.eye(15))
    heat = local_heats(x_mm, rig.screw, seconds)
    heat[:, BEGINS:] = 0.0
    return Change(value(x_mm), model, 25.0 + 0.004**2 * np.eye(15), np.zeros(15), heat)


@pytest.mark.parametrize("beside_mm", [0.0, 20.0, 40.0])
def test_heat_is_told_from_a_drift_as_soon_as_the_next_ones_would_show_it(paper, beside_mm):
    rig, others = paper[0], np.delete(np.arange(15), ONE)
    for seconds, told in ((60.0, False), (1200.0, True)):
        warmed = change_of(
            rig, lambda x, s=seconds: 2.0 * rig.screw.warmed(x - x[ONE] - beside_mm, LATE * s), seconds
        ).tested(ONE, others, AS_IT_IS)
        alone = change_of(rig, lambda x, by=warmed.value: by * (np.arange(15) == ONE), seconds).tested(
            ONE, others, AS_IT_IS
        )
        assert (warmed.is_heat, warmed.not_heat > 1.0) == (told, False)
        assert (alone.is_heat, alone.not_heat > 1.0) == (False, told)


def test_without_a_bar_no_heat_explains_a_drift():
    assert not local_heats(np.arange(5.0), None, 600.0).any()


@pytest.fixture(scope="module")
def chips(paper, tmp_path_factory):
    """Two minutes of strokes, and then hot chips of 3 W on the screw at 415 mm, beside T05; and how much it grows."""
    run = simulate("CS-20", seed=5, seconds=SECONDS, plant={"parked_chips": 2.0})
    log = write(run, tmp_path_factory.mktemp("rig") / "chips.log")
    recording = read_recording(log, paper[0])
    return recording, np.interp(recording.time_s, run.truth.time_s, run.truth.elongation_um)


@pytest.fixture(scope="module")
def track(chips, paper):
    return replay(paper[1], paper[0], chips[0])


def test_a_thermometer_that_reads_such_heat_is_suspected_until_the_next_ones_show_it(track):
    suspected = np.flatnonzero(track.may_drift_K[:, ONE])
    assert suspected.size
    assert suspected[-1] < len(track) - 100
    assert not (track.fault > Fault.JUDGED).any()
    assert (np.flatnonzero(track.lacks_K[:, ONE]) == np.arange(suspected[-1] + 1, len(track))).all()
    assert track.lacks_K[-1, ONE] > 0.3
    assert not np.delete(track.lacks_K, ONE, axis=1).any()


def test_the_sd_holds_what_is_not_known_of_it(track, chips):
    error = abs(chips[1] - track.elongation_um)[1:]
    assert error.max() > 0.5
    assert (error < np.maximum(5.0 * track.sigma_um[1:], 0.5)).all()
    assert track.unsure_um.max() > 0.5
    assert (track.unsure_um[1:] <= track.sigma_um[1:]).all()
    first = np.flatnonzero(track.may_drift_K[:, ONE])[0]
    begins = np.flatnonzero(track.unsure_um)[0]  # it departs, as models lack in detail, until it is suspected
    assert SECONDS // 10 < begins < first
    assert (track.unsure_um[begins:first] < 0.5).all()


def test_while_the_telemeter_is_silent_it_goes_on_and_nobody_has_jumped(paper, tmp_path):
    """Hot chips of 6 W: T05 and T06 are 0.9 and 0.6 K further when they are read again than they should be."""
    run = simulate("CS-20", seed=5, seconds=SECONDS, plant={"parked_chips": 4.0})
    recording = read_recording(write(run, tmp_path / "silent.log"), paper[0])
    recording.channels[700:1100, paper[0].is_thermometer] = np.nan
    track = replay(*paper[::-1], recording)
    assert track.innovation[1100, ONE] > 0.8
    assert not (track.fault[1100:] != Fault.NONE).any()


def test_where_heat_is_missing_already_a_short_silence_is_enough(track, chips, paper):
    """It draws its place towards the model, without which the readings would hold it: as if it had jumped."""
    k = int(np.flatnonzero(track.lacks_K[:, ONE])[0]) + 100
    recording = chips[0].rows(slice(0, k + 60))
    readings = recording.channels.copy()
    readings[k : k + 15, paper[0].is_thermometer] = np.nan
    readings[k + 15 :, ONE] += 0.5
    silent = replay(*paper[::-1], replace(recording, channels=readings))
    assert not (silent.fault != Fault.NONE).any()
    readings[k + 15 :, ONE] += 3.0
    silent = replay(*paper[::-1], replace(recording, channels=readings))
    assert silent.fault[-1, ONE] == Fault.JUMPED


def test_its_zero_is_what_it_was_and_live_says_so_as_well(track, chips, rig, shipped):
    """Before that the zero had taken what is heat now; from that tick on the estimate has it."""
    k = int(np.flatnonzero(track.may_drift_K[:, ONE])[-1]) + 1
    assert track.elongation_um[k] - track.elongation_um[k - 1] > 0.2
    live = stepped(Filter(shipped, rig), chips[0].rows(slice(k + 20)))
    for key in ("elongation_um", "sigma_um", "unsure_um", "lacks_K", "may_drift_K", "profile_sd_K", "innovation"):
        found, batch = getattr(live, key), getattr(track, key)[: k + 20]
        np.testing.assert_allclose(found, batch, rtol=1e-9, atol=1e-9, err_msg=key)


def test_of_a_thermometer_that_fails_nothing_says_any_more_that_it_reads_heat(chips, paper):
    readings = chips[0].channels.copy()
    readings[SECONDS - 50 :, ONE] -= 20.0
    track = replay(paper[1], paper[0], replace(chips[0], channels=readings))
    assert track.lacks_K[SECONDS - 51, ONE] > 0.3
    assert track.fault[-1, ONE] == Fault.JUMPED
    assert track.lacks_K[-1, ONE] == 0.0


def test_two_neighbours_that_drift_alike_are_suspected_and_lead_the_estimate_nowhere(strokes, paper):
    (rig, model), healthy, first = paper, strokes(2100), 9
    readings, both, since_s = healthy.channels.copy(), [first, first + 1], np.maximum(healthy.time_s - 1500.0, 0.0)
    readings[:, both] += 3.0 / 3600.0 * since_s[:, None]
    track, usual = replay(model, rig, replace(healthy, channels=readings)), replay(model, rig, healthy)
    known = (track.may_drift_K != 0.0) | (track.fault == Fault.DRIFTING)
    assert (np.argmax(known[:, both], axis=0) - 1500 < 150).all()
    assert not np.delete(known, both, axis=1).any()
    assert np.nanmax(abs(track.elongation_um - usual.elongation_um)) < 0.3
