"""Candidates on a rig, and the screen that ranks them."""

import numpy as np
import pytest

from estimator.batch.trials import slow_trials_of
from estimator.effects import CATALOGUE
from estimator.hypotheses.candidates import candidates, kind_of, places
from estimator.hypotheses.ground import Ground
from estimator.hypotheses.hypothesis import refined
from estimator.hypotheses.moments import moments
from estimator.hypotheses.screening import screening
from estimator.work import Runs
from tests.estimator.conftest import with_effect


def test_candidates_fit_the_rig_and_are_absent(plain, bar):
    wide, found = candidates(plain, bar, CATALOGUE.values())
    names = {c.name for c in found}
    assert {"churning", "local_heat", "radiation", "sensor_lag", "expansion_error", "channel_gain"} <= names
    assert not names & set(plain.effects)
    assert not names & {"motor_heat", "anchor_housing", "bearing_speed_exponent"}  # no bearing on this bar
    assert sum(c.name == "channel_offset" for c in found) == len(bar.thermometers)
    assert sum(c.name == "local_heat" for c in found) == len(places(bar))
    for each in found:
        assert each.kind == kind_of(wide, each.name, bar)
    assert {c.name: c.kind for c in found}["sensor_lag"] == "reading"
    assert {c.name: c.kind for c in found}["base_drift"] == "heat"


def test_all_candidates_at_their_nulls_leave_the_model_as_it_is(plain, bar, lives):
    wide, _ = candidates(plain, bar, CATALOGUE.values())
    runs = lives(plain)[:1]
    (alone,), (beside,) = (
        moments(slow_trials_of(model, Runs(bar, runs)), model, []) for model in (plain, wide)
    )  # fmt: skip
    np.testing.assert_allclose(beside.heat, alone.heat, rtol=1e-9)


def test_the_screen_puts_the_planted_place_first(plain, bar, lives):
    runs = lives(with_effect(plain, "local_heat", power=2.0, at=150.0))
    wide, found = candidates(plain, bar, CATALOGUE.values())
    best = screening(Ground(plain, ()), wide, found, slow_trials_of(wide, Runs(bar, runs))).best()[0]
    assert best.candidate.name == "local_heat"
    assert best.candidate.at["local_heat.at"] == pytest.approx(150.0, abs=20.0)
    assert best.first["local_heat.power"] == pytest.approx(2.0, rel=0.3)


def test_a_fit_in_full_finds_place_and_size(plain, bar, lives):
    runs = lives(with_effect(plain, "local_heat", power=2.0, at=150.0))
    wide, found = candidates(plain, bar, [CATALOGUE["local_heat"]])
    seat = min(found, key=lambda c: abs(c.at["local_heat.at"] - 120.0))
    h = refined(Ground(plain, ()), slow_trials_of(wide, Runs(bar, runs)), [seat], {"local_heat.power": 1.0})
    values = h.known().values
    assert values["local_heat.at"].value == pytest.approx(150.0, abs=3.0)
    assert values["local_heat.power"].value == pytest.approx(2.0, rel=0.03)
    assert h.misfit < 1.0
