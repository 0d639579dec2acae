"""What doubtful parameters add to the uncertainty: against a rig that is so, tick by tick and in batch."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.replay import replay
from estimator.effect import Effect, Param
from estimator.filter import Filter
from estimator.model import Value
from estimator.state.doubt import root
from estimator.terms import Lag
from tests.conftest import stepped

pytestmark = pytest.mark.usefixtures("no_other_machine", "no_lies")
DOUBTFUL = {  # a step that is small enough to be linear, and one of each kind
    "still_air.h": 0.01, "nut_friction.power": 0.05, "nut_friction.power_nut": 0.05, "nut_friction.n": 1e-3,
    "nut_body.capacity": 1.0, "nut_body.g": 0.002, "conduction.scale": 1e-3, "thermometers.tau": 0.01,
    "thermometers.board": 1e-5, "displacement.probe": 1e-4, "displacement.bar": 1e-4,
}  # fmt: skip


@pytest.fixture(scope="module")
def run(small, driven):
    """Drive and rest, everything around becoming warmer at its own pace."""
    drive = driven(small, 400, (20, 260), stroke=(0.0, 100.0))
    for k, name in enumerate(name for name in small.inputs if name != "position"):
        drive.inputs[name][:] = 22 + (k + 1) / 400 * np.arange(400)
    return drive


@pytest.fixture(scope="module")
def known(small_model):
    """The model with nothing in doubt."""
    return small_model.with_values({"thermometers.gain_sd": 0.0, "thermometers.lag_sd": 0.0})


def added(known, doubtful, rig, recording):
    """What doubts add to the standard deviation of the elongation, (K,) um."""
    sd = [replay(model, rig, recording).sigma_um for model in (known, doubtful)]
    return np.sqrt(np.maximum(sd[1] ** 2 - sd[0] ** 2, 0.0))


@pytest.mark.parametrize(("path", "step"), DOUBTFUL.items())
def test_the_estimate_of_a_rig_with_another_parameter_is_off_by_what_is_said(path, step, known, small, run, live):
    """Of one whose sd is the step: readings without scatter of a rig that is one step off, by the usual model."""
    usual, other = (live(known.with_values({path: known[path] + by}), small, run) for by in (0.0, step))
    alone, track = (replay(known, small, lived.recording) for lived in (usual, other))
    off = (other.elongation_um - track.elongation_um) - (usual.elongation_um - alone.elongation_um)
    said = added(known, known.with_values({path: Value(known[path], step)}), small, usual.recording)
    np.testing.assert_allclose(said, abs(off), rtol=0.02, atol=0.02 * abs(off).max())


def test_a_thermometer_of_another_gain_moves_the_estimate_as_said(known, small, run, live):
    gain = 0.002
    lived = live(known, small, run)
    alone, off = replay(known, small, lived.recording).elongation_um, np.zeros((4, len(run)))
    for i in range(4):
        channels = lived.recording.channels.copy()
        channels[:, i] += gain * (channels[:, i] - channels[0, i])
        off[i] = replay(known, small, replace(lived.recording, channels=channels)).elongation_um - alone
    said = added(known, known.with_values({"thermometers.gain_sd": gain}), small, lived.recording)
    wanted = np.sqrt((off**2).sum(axis=0))
    np.testing.assert_allclose(said, wanted, rtol=0.02, atol=0.02 * wanted.max())


class OwnLag(Effect):
    """One thermometer lags more than the others: tau_i = tau + by."""

    by, channel = Param(0.0, "s"), Param(0.0, "1")

    def terms(self, p, u, rig):
        for number, name in enumerate(rig.thermometers):
            yield Lag(name, p.by * (number == p.channel))


def test_a_thermometer_of_another_lag_moves_the_estimate_as_said(known, small, run, live):
    share = 0.01
    other, off = known + OwnLag, np.zeros((4, len(run)))
    lived = live(known, small, run)
    alone = replay(known, small, lived.recording).elongation_um
    for i in range(4):
        late = other.with_values({"own_lag.by": share * known["thermometers.tau"], "own_lag.channel": i})
        off[i] = replay(known, small, live(late, small, run).recording).elongation_um - alone
    said = added(known, known.with_values({"thermometers.lag_sd": share}), small, lived.recording)
    wanted = np.sqrt((off**2).sum(axis=0))
    assert wanted.max() > 1e-3
    np.testing.assert_allclose(said, wanted, rtol=0.02, atol=0.02 * wanted.max())


def test_live_doubts_as_batch_does(small_model, small, run, live):
    """Profile, table and elongation, with gaps; and correlations count."""
    model = small_model.with_values({path: Value(small_model[path], 100 * step) for path, step in DOUBTFUL.items()})
    recording = live(small_model, small, run, seed=3, process=True).recording
    recording.channels[1:][np.random.default_rng(1).random((399, 5)) < 0.3] = np.nan
    paths = ["nut_friction.power", "nut_body.capacity"]
    together = model.about | {"covariance": {"paths": paths, "correlation": [[1.0, -0.9], [-0.9, 1.0]]}}
    wide, narrow = (replay(each, small, recording) for each in (model, replace(model, about=together)))
    assert abs(wide.sigma_um - narrow.sigma_um).max() > 1e-4
    step = stepped(Filter(replace(model, about=together), small), recording)
    for key in ("sigma_um", "profile_sd_K", "elongation_um"):
        np.testing.assert_allclose(getattr(step, key), getattr(narrow, key), rtol=0, atol=1e-9)
    usual = replay(small_model, small, recording)
    np.testing.assert_array_equal(usual.elongation_um, narrow.elongation_um)
    assert (narrow.sigma_um[60:] > usual.sigma_um[60:]).all()


def test_an_effect_that_is_left_out_takes_its_own_doubts_with_it(small_model, small, run, live):
    """Those of the others stay as they were."""
    doubts = {path: Value(small_model[path], 0.3) for path in ("still_air.h", "displacement.probe")}
    recording = live(small_model, small, run).recording
    both, one = (small_model.with_values({path: doubts[path] for path in list(doubts)[first:]}) for first in (0, 1))
    filters = [Filter(model, small) for model in (both, one, small_model)]
    for k in range(80):
        for each in filters:
            each.step(recording.sample(k))
    for each in filters:
        each.leave_out("still_air")
    sd = [each.step(recording.sample(80)).sigma_um for each in filters]
    assert sd[0] == pytest.approx(sd[1], rel=1e-9)
    assert sd[1] > sd[2]


def test_a_root_of_a_covariance_that_was_rounded():
    cov = np.array([[1.0, 1.0001], [1.0001, 1.0]])
    np.testing.assert_allclose(root(cov) @ root(cov).T, cov, atol=2e-4)
