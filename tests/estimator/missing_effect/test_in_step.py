"""Which thermometers jump in step with the drive, and are heard by those who look for what the model lacks."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.trials import slow_trials_of
from estimator.faults.fault import Fault, Spell
from estimator.faults.use import ChannelUse, Jump, Use
from estimator.missing_effect.in_step import drifts_always, in_step
from estimator.work import Runs

STARTS, STOPS = 200, 500
NONE = float("nan")


@pytest.fixture
def drives(small, driven):
    """Two recordings of one drive each."""
    run = driven(small, 900)
    omega = np.where((np.arange(900) >= STARTS) & (np.arange(900) < STOPS), 100.0, 0.0)
    return [replace(run, omega=omega, name=name) for name in ("one", "two")]


def use(rig, spells=(), jumps=(), fault=Fault.JUMPED) -> Use:
    """What is said of a recording in which the second thermometer was broken from these times on, or jumped then."""
    broken = tuple(Spell(fault, at, NONE) for at in spells)
    channels = [ChannelUse(name, 900, 900, {}, broken if i == 1 else (), ()) for i, name in enumerate(rig.thermometers)]
    sizes = {rig.thermometers[1]: 0.4}
    return Use("run", 0.0, False, tuple(channels), tuple(Jump(at, sizes) for at in jumps), {}, {}, (), ())


@pytest.mark.parametrize(
    ("first", "second", "heard"),
    [
        (([STARTS + 5.0], []), ([], [STOPS + 20.0]), True),
        (([STARTS + 5.0, STOPS + 5.0], []), ([STOPS + 30.0], [STARTS + 1.0]), True),
        (([STARTS + 5.0], []), ([], []), False),  # once may be chance
        (([20.0], []), ([20.0], []), False),  # a recording that begins at rest begins at no stop
        (([STARTS + 5.0], []), ([STARTS + 150.0], []), False),
        (([STARTS + 5.0], []), ([STARTS + 5.0], [STOPS + 90.0]), False),
    ],
)
def test_what_jumps_with_the_drive_in_two_recordings_is_no_fault(small, drives, first, second, heard):
    uses = [use(small, *first), use(small, *second)]
    assert in_step(uses, drives, small) == ([small.thermometers[1]] if heard else [])


@pytest.mark.parametrize(
    ("drifts", "heard"), [([1, 1], True), ([1, 1, 0], True), ([1, 0], False), ([1, 1, 0, 0], False)]
)
def test_what_drifts_in_most_recordings_may_be_a_law(small, drifts, heard):
    uses = [use(small, [300.0] * each, fault=Fault.DRIFTING) for each in drifts]
    assert drifts_always(uses, small) == ([small.thermometers[1]] if heard else [])
    assert drifts_always([use(small, [300.0])] * 2, small) == []  # that jumped
    all_drift = [replace(u, channels=tuple(replace(c, spells=u.channels[1].spells) for c in u.channels)) for u in uses]
    assert drifts_always(all_drift, small) == []  # so does the model


def test_without_a_drive_nothing_keeps_step(small, driven):
    rests = [replace(driven(small, 900), omega=np.zeros(900))] * 2
    assert in_step([use(small, [205.0]), use(small, [205.0])], rests, small) == []


def test_such_a_thermometer_is_heard_as_it_reads(rig, full, live, driven):
    """Half a kelvin more while the screw turns: who fits leaves it out, who looks for what is missing does not."""
    runs = [live(full, rig, driven(rig, 1500, (300, 900)), seed=seed).recording for seed in (1, 2)]
    at = rig.index("T06")
    for k, run in enumerate(runs):
        channels = run.channels.copy()
        channels[:, at] += 0.5 * (run.omega > 0)
        runs[k] = replace(run, channels=channels, name=f"run {k}")
    judged = slow_trials_of(full, Runs(rig, runs))
    assert in_step(judged.uses, runs, rig) == ["T06"]
    believed = slow_trials_of(full, Runs(rig, runs), believed=["T06"])
    for left_out, heard in zip(judged.uses, believed.uses, strict=True):
        assert left_out.channels[at].used < 0.7 * left_out.channels[at].taken
        assert heard.channels[at].used == heard.channels[at].taken
        assert not heard.suspects
