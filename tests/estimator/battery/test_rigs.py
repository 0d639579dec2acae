"""The battery on rigs without a screw, and on those of the examples."""

from dataclasses import replace
from pathlib import Path

import pytest

from estimator.battery.battery import battery
from estimator.effect import Effect, Param
from estimator.rig import Channel, Rig, Signal
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from estimator.terms import Heat, Link, Read, Store


class Cup(Effect):
    """A cup cools in the air.

    C dT/dt = -g (T - T_air)
    """

    g = Param(2.0, "W/K", lo=0.0, hi=9.0, null=0.0, source="a guess")

    def terms(self, p, u, rig):
        yield Store("cup", 50.0, 0.1)
        yield Read("T1", {"cup": 1.0}, 0.02)
        yield Link("cup", "ambient", p.g)


class Kettle(Effect):
    """A coil heats the cup.

    q = share P
    """

    share = Param(0.9, "1", lo=0.0, hi=1.0, null=0.0, source="what the leads do not take away")

    def terms(self, p, u, rig):
        yield Heat("cup", p.share * u["coil"])


def test_a_rig_without_a_screw_or_nut(full):
    inputs = {"ambient": Signal(), "coil": Signal(unit="W", lo=0.0, hi=50.0)}
    cup = Rig("cup", 5.0, {"T1": Channel(node="cup")}, inputs)
    base = replace(full, effects={}, values={}) + Cup
    assert [f.detail for f in battery(Kettle, base, cup) if not f.ok] == []
    assert [f.detail for f in battery(Cup, base, cup) if not f.ok] == []


@pytest.mark.parametrize("name", ["heated_rod", "seven_channels"])
def test_the_examples_own_rigs(name):
    folder = Path(__file__).parents[3] / "examples" / name
    model, rig = load_model(folder / "model.toml"), load_rig(folder)
    for effect in model.effects.values():
        found = battery(type(effect), model, rig)
        assert [f for f in found if not f.ok] == []
        lacking = {"board", "bore"}  # the rod has neither
        assert {part.split()[0] for f in found for part in f.detail.split("; ") if f.detail} <= lacking
