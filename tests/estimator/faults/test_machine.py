"""By which share the parameters are off: against one big normal distribution, and machines that are not the model's."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from estimator.batch.replay import replay
from estimator.faults import machine
from estimator.faults.beside import windows
from estimator.faults.fault import Led, Seen
from estimator.faults.machine import SHARES, Known, Machine
from estimator.filter import Filter
from estimator.step import SERIES
from tests.conftest import stepped

TICK_S, LOOKS, SD = 10.0, 9, 0.04
HEAT = np.array([True, True, True, False])
SECONDS = 900


def looks(seed, off):
    """Of three parameters that are off by so much: misfits (K, 4), how they move (K, 4, 3); what is known of them."""
    dice = np.random.default_rng(seed)
    moved = np.cumsum(dice.normal(size=(LOOKS, 4, 3)), axis=0)
    known = Known(np.diag([0.1, 0.02, 0.05]) + 0.01 * np.tri(3, k=-1), np.array([1.0, 2.0, 0.0]))
    return moved @ off + dice.normal(0.0, 0.05, (LOOKS, 4)), moved, known


def heard(y, moved, known, tick_s=TICK_S):
    """The bank after a look at each of them."""
    bank = Machine(known, HEAT, tick_s)
    for k in range(len(y)):
        now = slice(k, k + 1)
        seen = Seen(
            np.array([k * tick_s]),
            y[now],
            y[now],
            np.full((1, 4), SD),
            0 * y[now],
            y[now] > np.inf,
            moved[now],
            Led.nowhere(1, 3),
            np.zeros(1, dtype=bool),
            np.ones(1, dtype=bool),
        )
        bank.hear(seen, slice(None), np.isfinite(y[now]))
        bank.block(1)
    return bank


def covariance(moved, known, share):
    """Of all misfits after the first, less that one: of parameters, and of what lasts, which begins with nothing."""
    D = (moved - moved[0])[1:].transpose(1, 0, 2).reshape(-1, 3)
    r, age = np.exp(-TICK_S / machine.LASTS_S), np.abs(np.subtract.outer(np.arange(1, LOOKS), np.arange(1, LOOKS)))
    first = np.minimum.outer(np.arange(1, LOOKS), np.arange(1, LOOKS))
    lasting = r**age * (1 - r ** (2 * first))
    size = SD**2 + np.where(HEAT, machine.DETAILS[True], machine.DETAILS[False]) ** 2
    C = known.root @ known.root.T + share**2 * np.diag(known.whole**2)
    return D @ C @ D.T + np.kron(np.diag(size), lasting)


@pytest.mark.parametrize("off", [(0.0, 0.0, 0.0), (0.2, -0.3, 0.05)], ids=["the model's", "another"])
def test_the_weights_are_those_of_one_big_normal_distribution(off, monkeypatch):
    monkeypatch.setattr(machine, "OUTLYING", np.inf)
    y, moved, known = looks(0, off)
    bank, all_y = heard(y, moved, known), (y - y[0])[1:].T.ravel()
    first = np.where(SHARES > 0, machine.ANOTHER / (len(SHARES) - 1), 1 - machine.ANOTHER)
    log = np.array([multivariate_normal(cov=covariance(moved, known, s)).logpdf(all_y) for s in SHARES])
    log += np.log(first) - np.where(SHARES > 0, machine.DETAILS_PER_S * TICK_S * LOOKS, 0.0)
    weight = np.exp(log - log.max())
    assert bank.share == pytest.approx(np.sqrt(weight @ SHARES**2 / weight.sum()), rel=1e-6)


def test_a_channel_that_is_read_now_and_then_tells_as_much_as_if_the_rest_had_never_been(monkeypatch):
    """What is between two readings of it is nothing, whatever it moved by."""
    monkeypatch.setattr(machine, "OUTLYING", np.inf)
    y, moved, known = looks(1, (0.1, 0.1, 0.0))
    y[1::2] = np.nan
    assert heard(y, moved, known).share == pytest.approx(heard(y[::2], moved[::2], known, 2 * TICK_S).share, rel=0.05)


def test_one_thermometer_alone_makes_no_other_machine():
    y, moved, known = looks(2, (0.0, 0.0, 0.0))
    y[:, 1] += 5.0 * np.arange(LOOKS)
    alone = heard(y, moved, known).share
    assert alone == pytest.approx(heard(np.where(np.arange(4) == 1, np.nan, y), moved, known).share, abs=0.02)


def test_without_parameters_in_doubt_nothing_is_said():
    y, moved, known = looks(3, (1.0, 1.0, 1.0))
    assert heard(y, moved, replace(known, whole=np.zeros(3))).share == 0.0


@pytest.fixture(scope="module")
def recording(strokes):
    return strokes(SECONDS)


@pytest.fixture(scope="module")
def another(paper):
    """The model with all that stores heat or gives it away a fifth too large, and all that makes it too small."""
    model, values = paper[1], {}
    for path in model.doubts.paths:
        effect, _, key = path.partition(".")
        if effect.partition("_")[0] not in ("thermometers", "displacement") and key not in ("shift", "width"):
            values[path] = model[path] * (1 / 1.2 if key.startswith("power") else 1.2)
    return model.with_values(values)


def test_the_models_own_machine_is_known_within_a_minute_of_its_drive(recording, rig, shipped):
    share = replay(shipped, rig, recording).off_share
    assert share[0] == 0.0
    assert share[1:20] == pytest.approx(np.sqrt(machine.ANOTHER * (SHARES[1:] ** 2).mean()), rel=0.02)
    assert share[80:150].max() < 0.03
    assert not share[-200:].any()


def test_another_machines_estimate_says_how_far_it_is_off(recording, another, rig, shipped, monkeypatch):
    """By the estimate of its own model; without the share it would not."""
    off = replay(shipped, rig, recording).elongation_um
    track = replay(another, rig, recording)
    off = abs(off - track.elongation_um)[1:]
    assert 0.1 < track.off_share[-1] < 0.4
    assert (off <= 2 * track.sigma_um[1:]).mean() > 0.95
    monkeypatch.setattr(machine, "SHARES", np.zeros(len(SHARES)))
    monkeypatch.setattr(machine, "LED_SDS", 1e9)  # it takes the model for exact, and a right length for a wrong one
    monkeypatch.setattr(windows, "RECENT", 0)  # and what departs for what it says
    bare = replay(another, rig, recording)
    np.testing.assert_allclose(bare.elongation_um, track.elongation_um, rtol=0, atol=1e-9)
    assert (off <= 2 * bare.sigma_um[1:]).mean() < 0.5


def test_live_says_the_same_as_after_the_fact_and_learns_anew_after_hours(recording, another, paper, monkeypatch):
    monkeypatch.setattr(machine, "RENEWED_S", 150.0)
    some = recording.rows(slice(0, 300))
    some.channels[200:203] = np.nan
    live, batch = stepped(Filter(another, paper[0]), some), replay(another, paper[0], some)
    assert 0.1 < batch.off_share[-1] < 0.4
    for key in SERIES:
        np.testing.assert_allclose(getattr(live, key), getattr(batch, key), rtol=1e-9, atol=1e-9, err_msg=key)


def test_lengths_are_apart_by_how_well_thermometers_know_and_fit():
    known, ways = Known(np.diag([0.3, 0.0]), np.array([1.0, 2.0])), np.array([[1.0, 0.0]])

    def apart(um, worse, share=0.0, known=known):
        led = Led(np.array([um]), np.array([0.4**2]), ways, np.ones(1), np.array([worse]))
        return known.apart(led, share, 0.0)[0]

    limit = machine.LED_SDS * 0.5  # 0.4 and 0.3 um
    assert [apart(share * limit, 1.0) for share in (-1.01, 0.99, 1.01)] == [True, False, True]
    assert not apart(1.9 * limit, 2.0)
    assert not apart(1.9 * limit, 1.0, share=1.0)
    assert not apart(100.0, 1.0, known=replace(known, whole=np.zeros(2)))


def test_how_badly_thermometers_fit_is_learnt_in_a_minute_and_forgotten_in_a_quarter_of_an_hour():
    usual = Led.nowhere(1, 0)
    minute, worse = usual.worsened(np.full(300, 9.0), 1.0)
    assert worse[-1] == pytest.approx(3.0, rel=0.01)
    assert minute[59] - 1.0 == pytest.approx(8.0 * (1.0 - np.exp(-1.0)))
    bad = replace(usual, minute=minute[-1:], worse=worse[-1:])
    assert bad.worsened(np.full(600, np.nan), 1.0)[1][-1] == pytest.approx(worse[-1])
    assert bad.worsened(np.ones(900), 1.0)[1][-1] == pytest.approx(worse[-1] * np.exp(-0.9), rel=1e-6)
