"""What only the displacement shows: probes, bar and expansion are found, at rest too, and nothing else is moved."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.trials import trials_of
from estimator.effects.length import ExpansionError
from estimator.fit.calibration import calibrated
from estimator.model import EXPANSION, Value
from estimator.work import Runs

TRUE = {"displacement.probe": 0.55, "displacement.bar": 0.15}
TABLE = {"displacement.probe": Value(0.3, 1.0), "displacement.bar": Value(0.3, 1.0), EXPANSION: Value(0.0, 0.02)}
GREW = 0.012  # by which share more than the rig file says


@pytest.fixture(scope="module")
def model(small_model):
    """The small bar's, with what only the displacement shows in doubt, and a friction too."""
    sure = {path: Value(value.value, fixed=value.fixed) for path, value in small_model.values.items()}
    return (small_model.with_values(sure) + ExpansionError).with_values(
        TABLE | {"nut_friction.power": Value(60.0, 1.0)}
    )


@pytest.fixture(scope="module")
def recording(model, small, driven, live):
    """A drive and an hour of rest: probes warm in the drive and cool in the rest, the bar goes on to warm."""
    drive, t = driven(small, 4500, (20, 900), stroke=(0.0, 100.0)), np.arange(4500.0)
    drive.inputs["probe"][:] = 22.0 + 2.0 * np.where(t < 900, t / 900, np.exp(-(t - 900) / 600))
    drive.inputs["bar"][:] = 22.0 + 2.0 * (1.0 - np.exp(-t / 2000))
    lived = live(model.with_values(TRUE), small, drive, seed=4, expansion=GREW)
    rise = {name: drive.inputs[name] - 22.0 for name in ("probe", "bar")}
    shown = lived.elongation_um + TRUE["displacement.probe"] * rise["probe"] - TRUE["displacement.bar"] * rise["bar"]
    noise = 0.1 * np.random.default_rng(5).standard_normal(len(t))
    direct = np.where(drive.omega > 0.0, np.nan, shown - 40.0 + noise)
    channels = lived.recording.channels.copy()
    channels[drive.omega == 0.0, small.index("displacement")] = np.nan
    return replace(lived.recording, channels=channels, inputs=drive.inputs | {"displacement_direct": direct})


def told(model, rig, recording, free=tuple(TABLE)):
    return calibrated(model, trials_of(model, Runs(rig, [recording])), free)


def test_probes_bar_and_expansion_are_found_and_friction_stays(model, small, recording):
    found = told(model, small, recording)
    for path, true in (TRUE | {EXPANSION: GREW}).items():
        value = found.values[path]
        assert abs(value.value - true) < 2.5 * value.sd, path
        assert value.sd < 0.5 * TABLE[path].sd, path
    assert found.values["nut_friction.power"] == model.values["nut_friction.power"]
    assert {path for path in model.values if found.values[path] != model.values[path]} == set(TABLE)


def test_rests_tell_what_drives_cannot(model, small, recording):
    silent = replace(recording, inputs={k: v for k, v in recording.inputs.items() if k != "displacement_direct"})
    with_rest, without = (told(model, small, each) for each in (recording, silent))
    for path in TABLE:
        assert with_rest.values[path].sd < 0.9 * without.values[path].sd <= TABLE[path].sd, path


def test_a_model_that_is_sure_or_sees_no_displacement_stays(model, small, recording):
    unread = replace(recording, channels=recording.channels.copy())
    unread.channels[:, small.index("displacement")] = np.nan
    inputs = {k: v for k, v in recording.inputs.items() if k != "displacement_direct"}
    same = told(model, small, replace(unread, inputs=inputs))
    assert {path: same[path] for path in model.values} == {path: model[path] for path in model.values}
    sure = model.with_values({path: Value(value.value) for path, value in TABLE.items()})
    assert told(sure, small, recording) is sure


def test_what_is_not_free_stays(model, small, recording):
    found = told(model, small, recording, free=["displacement.bar"])
    assert {path for path in model.values if found.values[path] != model.values[path]} == {"displacement.bar"}
