"""Everything unknown that a search can find is written as an effect that passes all checks and says the same."""

import ast
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest

from estimator.battery.battery import battery
from estimator.battery.exercise import instants
from estimator.hypotheses.candidates import Candidate
from estimator.inputs.follower import TEMPERATURE, all_followers
from estimator.model import Value
from estimator.rig import Signal
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.terms import Heat, Link
from estimator.unknown.effect_text import effect_text
from estimator.unknown.law import law_of
from estimator.unknown.stand_ins import (
    Unknown,
    UnknownBodyHeat,
    UnknownHeat,
    UnknownReading,
    UnknownSpreadHeat,
    unknown_of,
)
from estimator.unknown.written import effect_of, name_of, wanted_of
from tests.conftest import PAPER, RIG, TWO

MODEL = load_model(PAPER / "model.toml")
BODIES, OF_BODIES = load_rig(TWO), load_model(TWO / "model.toml")
FOLLOWERS = all_followers(RIG)
SEATS = [
    (UnknownHeat, {"at": 350.0}, {"power": 3.0}),
    (UnknownSpreadHeat, {"under": 0.0}, {"power": 3.0}),
    (UnknownSpreadHeat, {"under": 1.0}, {"power": -3.0}),
    (UnknownReading, {"channel": 0.0}, {"offset": 0.2}),
    (UnknownReading, {"channel": 4.0}, {"offset": 0.2}),
    (UnknownReading, {"channel": float(1 + RIG.names.index("displacement"))}, {"offset": 0.2}),
]
STRENGTHS = ("power", "g", "shift")


def all_seats():
    for effect, where, strength in SEATS:
        for i, follower in enumerate(FOLLOWERS):
            if effect is UnknownReading and follower.loss:
                continue
            at = {f"{effect.name}.{key}": value for key, value in {**where, "follows": float(i)}.items()}
            strength = {key: abs(size) if follower.loss else size for key, size in strength.items()}
            yield pytest.param(effect, at, strength, id=f"{effect.name} {where} {follower.name}")


def tally(model, rig, name, values):
    """What the terms of an effect come to, by node or channel, of three instants."""
    u, found = instants(rig), defaultdict[tuple[str, str], object](float)
    for term in model.with_values(values).terms_of(name, u, rig):
        if isinstance(term, Heat):
            found["W", term.node] = found["W", term.node] + np.asarray(term.q * term.over)
        elif isinstance(term, Link):
            found["W/K", term.a] = found["W/K", term.a] + np.asarray(term.g * term.over)
        else:
            found["offset", term.channel] = found["offset", term.channel] + np.asarray(term.offset)
    return {key: value for key, value in found.items() if np.any(value)}


def written(effect, at, size, rig=RIG):
    unknown = unknown_of(Candidate(effect, (), at, "", body=False), rig)
    return effect_text(wanted_of(unknown, name_of(unknown, ()), dict.fromkeys(STRENGTHS, Value(size))), rig)


def assert_same(model, rig, effect, at, strength):
    """The effect that is written for a stand-in is the stand-in."""
    (size,) = strength.values()
    text = written(effect, at, size, rig)
    same = effect_of(text)
    values = {f"{effect.name}.{key}": value for key, value in strength.items()}
    stood = tally(model + effect, rig, effect.name, {**at, **values})
    said = tally(model + same, rig, same.name, {})
    assert stood.keys() == said.keys(), text
    for key, value in said.items():
        np.testing.assert_allclose(*np.broadcast_arrays(value, stood[key]), rtol=1e-12, err_msg=f"{key}: {text}")


@pytest.mark.parametrize(("effect", "at", "strength"), list(all_seats()))
def test_what_is_written_says_what_its_stand_in_does(effect, at, strength):
    assert_same(MODEL, RIG, effect, at, strength)


@pytest.mark.parametrize("follower", all_followers(BODIES), ids=lambda follower: follower.name)
def test_so_it_does_of_a_body(follower):
    follows = float(all_followers(BODIES).index(follower))
    at = {"unknown_body_heat.node": 1.0, "unknown_body_heat.follows": follows}
    assert_same(OF_BODIES, BODIES, UnknownBodyHeat, at, {"power": 3.0})


@pytest.mark.parametrize("at_mm", [-40.0, 350.0, 980.0])
@pytest.mark.parametrize("follower", [f for f in FOLLOWERS if law_of(f).numbers], ids=lambda f: f.name)
def test_one_with_free_numbers_passes_all_checks(follower, at_mm):
    at = {"unknown_heat.at": at_mm, "unknown_heat.follows": float(FOLLOWERS.index(follower))}
    effect = effect_of(written(UnknownHeat, at, 3.0))
    assert not [finding for finding in battery(effect, MODEL, RIG) if finding.detail]
    assert {*law_of(follower).numbers} < {*effect.params}
    assert not [key for key, param in effect.params.items() if param.fixed]


def test_its_name_says_what_and_where_and_is_no_one_else_s():
    heat = unknown_of(Candidate(UnknownHeat, (), {"a.at": -12.4, "a.follows": 0.0}, "", body=False), RIG)
    assert name_of(heat, ["HeatNear10", "conduction"]) == "HeatNearMinus10"
    assert name_of(heat, ["heat_near_minus10", "HeatNearMinus10No2"]) == "HeatNearMinus10No3"
    loss = replace(heat, follower=TEMPERATURE, at_mm=None, node="anchor_housing")
    assert name_of(loss, ()) == "LossInAnchorHousing"
    assert name_of(replace(heat, channel="", at_mm=None), ()) == "ShiftOfAll"
    assert name_of(replace(heat, at_mm=None, under_nut=True), ()) == "HeatUnderNut"
    assert name_of(replace(heat, at_mm=None), ()) == "HeatAllAlong"


def test_what_was_found_is_within_its_bounds_and_cools_where_it_is_negative():
    at = {"unknown_heat.at": 350.0, "unknown_heat.follows": 0.0}
    unknown = unknown_of(Candidate(UnknownHeat, (), at, "", body=False), RIG)
    found = {"power": Value(-130.0, 2.0), "at": Value(351.2, 3.0), "width": Value(55.0, 9.0)}
    effect = effect_of(effect_text(wanted_of(unknown, "Jet", found, "found in 4 recordings"), RIG))
    assert effect.sentence() == "Something cools the screw around 350 mm, always."
    values = {key: param.value for key, param in effect.params.items()}
    assert values == {"power": -130.0, "at": 351.2, "width": 55.0}
    power = effect.params["power"]
    assert (power.lo, power.hi, power.null, power.source) == (-520.0, 520.0, 0.0, "found in 4 recordings, +- 2")


HOSTILE = ['T"""\nraise SystemExit(1)', "T\\", "a-b.c\r\nimport os", "Öl 1", "$power", "x\u2028y"]


@pytest.mark.parametrize("name", HOSTILE)
def test_a_name_of_the_rig_is_never_code(name):
    """rig.toml may come from anywhere: a search must not run what is written in it."""
    channel = replace(BODIES.channels["T1"], node=name)
    rig = replace(BODIES, channels={name: channel}, inputs={**BODIES.inputs, name: Signal(unit="%")})
    followers = [f for f in all_followers(rig) if f.name in (name, "always")]
    assert len(followers) == 2
    found = {"power": Value(1.0), "shift": Value(1.0)}
    for follower in followers:
        for unknown in (Unknown(follower, node=name), Unknown(follower, channel=name)):
            text = effect_text(wanted_of(unknown, name_of(unknown, ()), found), rig)
            effect = effect_of(text)
            (term,) = effect().terms(effect().namespace({}), instants(rig), rig)
            assert name in (getattr(term, "node", ""), getattr(term, "channel", ""))
            assert len(ast.parse(text).body) == 1
