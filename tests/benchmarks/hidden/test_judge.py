"""What the study of hidden effects takes for right."""

from collections import defaultdict
from dataclasses import replace

import pytest

from benchmarks.hidden.cases import EVERY, ODD, PAIRS, ROADS, Case, asked
from benchmarks.hidden.judge import SHIFTED, carried, confused, false_effects, follows_drawn, gained, right
from benchmarks.hidden.outcome import Outcome
from benchmarks.hidden.plants import BY_LAW, DRAWN, OWN
from drivers.virtual_rig.machine.drawn import drawn
from drivers.virtual_rig.machine.heaters import local_place
from drivers.virtual_rig.population.draw import machine
from drivers.virtual_rig.sensors.telemeter import telemeter

EFFECT, NOTHING = "effect", "nothing_missing"


def one(name: str, road: str) -> Case:
    """The first case in which this effect alone is hidden."""
    return next(case for case in asked(["one", "whole", road]) if case.hidden.names == (name,))


def carrying(case: Case, name: str, share: float) -> dict[str, list[float]]:
    """Values of own parameters that have moved by a share of what was planted."""
    values = {path: of(machine(case.machine)) for path, of in OWN[name].items()}
    return {path: [without + share * more] for path, (without, more) in values.items()}


@pytest.mark.parametrize("name", EVERY)
def test_an_effect_named_is_right_and_another_is_wrong(name):
    case = one(name, "healthy")
    other = EVERY[EVERY.index(name) - 1]
    assert right(case, Outcome(EFFECT, [name]))
    assert not right(case, Outcome(EFFECT, [other]))
    assert not right(case, Outcome(NOTHING))
    assert not right(case, Outcome(EFFECT, [name], error="ValueError: no"))


def test_a_tie_of_three_is_right_and_one_of_four_is_not():
    case = one("churning", "same")
    assert right(case, Outcome("tie", ["motor_heat", "radiation", "churning"]))
    assert not right(case, Outcome("tie", ["motor_heat", "radiation", "local_heat", "churning"]))


@pytest.mark.parametrize("name", OWN)
def test_half_of_what_was_planted_must_be_carried(name):
    case = one(name, "same")
    outs = {share: Outcome(NOTHING, values=carrying(case, name, share)) for share in (0.0, 0.4, 0.6, 1.0, 1.6)}
    assert [share for share, out in outs.items() if carried(case, out, name)] == [0.6, 1.0]
    assert right(case, outs[1.0])
    assert not right(case, outs[0.4])


@pytest.mark.parametrize("name", OWN)
def test_on_a_healthy_machine_the_parameter_that_carries_must_be_named(name):
    case = one(name, "healthy")
    silent = Outcome(NOTHING, values=carrying(case, name, 1.0))
    holders = [path.partition(".")[0] for path in OWN[name]]
    assert not right(case, silent)
    assert right(case, replace(silent, verdict=EFFECT, said=holders[:1], own=holders[:1]))
    assert right(case, replace(silent, own=holders[:1]))
    assert not right(case, replace(silent, verdict=EFFECT, said=["churning"]))


def test_where_a_parameter_carries_it_a_law_of_the_machine_may_be_named():
    case = one("probe_expansion", "same")
    values = carrying(case, "probe_expansion", 1.0)
    law = next(BY_LAW[law] for law in machine(case.machine).laws if law in BY_LAW)
    assert right(case, Outcome(EFFECT, [law], values=values))
    assert not right(case, Outcome(EFFECT, [law])), "nothing carries it"
    assert not right(case, Outcome(EFFECT, ["base_drift"], values=values)), "which the machine has not"
    assert not right(case, Outcome("input_error", values=values, wrong=("FS-5.blf", "speed")))


@pytest.mark.parametrize("name", SHIFTED)
def test_a_channel_that_is_shifted_may_be_left_out(name):
    case = one(name, "same")
    places = telemeter(case.seed, defaultdict(float, {name: 1.0}), machine(case.machine).sensors).places
    channel = f"T{places[name]:02.0f}"
    broken = [(f"{run}.blf", channel) for run in case.runs[0]]
    assert right(case, Outcome(NOTHING, faulty=broken[1:]))
    assert not right(case, Outcome(NOTHING, faulty=broken[2:])), "in half of the runs"
    assert not right(case, Outcome(NOTHING, faulty=[(run, "T01") for run, _ in broken]))


def test_nothing_planted_may_be_another_value_of_a_parameter():
    case = Case("none", "shipped", 0)
    assert right(case, Outcome(NOTHING))
    assert right(case, Outcome(EFFECT, ["nut_friction"], own=["nut_friction"]))
    assert right(case, Outcome("tie", ["support_yield", "nut_friction"], own=["nut_friction"]))
    assert not right(case, Outcome(EFFECT, ["support_yield"]))
    assert not right(case, Outcome("nothing_in_catalogue", place_mm=400.0, follows="drive"))


@pytest.mark.parametrize(("law", "effect"), BY_LAW.items())
def test_what_a_machine_has_by_a_law_of_its_own_is_there(law, effect):
    cases = asked(["none", "whole"])
    lawful, other = ([c for c in cases if (law in machine(c.machine).laws) is has] for has in (True, False))
    assert not false_effects(lawful[0], Outcome(EFFECT, [effect]))
    assert false_effects(other[0], Outcome(EFFECT, [effect])) == [effect]


def test_a_fixed_parameter_that_is_another_one_on_the_machine_is_an_effect():
    case = Case("none", "shipped", 0)
    ((path, of),) = OWN["nut_speed_exponent"].items()
    true, each = of(machine(case.machine))
    out = Outcome(EFFECT, ["nut_speed_exponent"])
    assert not right(case, out)
    assert right(case, replace(out, held={path: true - 0.6 * each}))
    assert not right(case, replace(out, held={path: true - 0.4 * each}))


def test_of_two_effects_both_must_be_found():
    case = Case("two", "healthy", 0)
    assert right(case, Outcome(NOTHING, list(PAIRS[0])))
    assert not right(case, Outcome(NOTHING, list(PAIRS[0][:1])))
    three = Case("three", "healthy", 0)
    assert right(three, Outcome(NOTHING, list(three.hidden.names[1:])))


def test_a_stranger_has_a_place_and_what_it_follows():
    case = Case("stranger", "healthy", 0)
    (name,) = case.hidden.names
    at_mm = local_place(case.seed, name)
    found = Outcome("nothing_in_catalogue", place_mm=at_mm + 59.0, follows="speed2")
    assert right(case, found)
    assert not right(case, replace(found, place_mm=at_mm + 61.0))
    assert not right(case, replace(found, follows="time"))
    assert right(case, replace(found, follows="time", as_well=["drive", "speed"])), "tied with what is right"


def test_an_event_is_told_within_ten_minutes():
    case = Case("event", "healthy", 0)
    out = Outcome(happened=("FS-5.blf", 1000.0), began=[("FS-5.blf", 1500.0, "heat_driving")])
    assert right(case, out)
    assert not right(case, replace(out, began=[("FS-5.blf", 1700.0, "heat"), ("CS-10.blf", 1000.0, "heat")]))
    assert not right(case, replace(out, began=[("FS-5.blf", 1000.0, "reading")]))


def test_a_wrong_input_needs_run_and_signal():
    case = Case("label", "healthy", 0)
    run = f"{case.runs[0][ODD]}.blf"
    assert right(case, Outcome("input_error", wrong=(run, "speed")))
    assert not right(case, Outcome("input_error", wrong=(run, "position")))
    assert not right(case, Outcome(EFFECT, ["churning"]))
    shifted, told = Case("shifted", "healthy", 0), Outcome("input_error", wrong=("all", "position"), shift_mm=38.0)
    assert right(shifted, told)
    assert not right(shifted, replace(told, shift_mm=25.0))
    assert not right(shifted, replace(told, wrong=("CS-20.blf", "position")))


def test_a_thermometer_that_fails_is_named_and_no_heat():
    case = Case("sensor", "healthy", 0)
    out = Outcome(NOTHING, broken=("CS-10.blf", "T05"), faulty=[("CS-10.blf", "T05")])
    assert right(case, out)
    assert not right(case, replace(out, faulty=[("CS-10.blf", "T06")]))
    assert not right(case, replace(out, verdict=EFFECT, said=["motor_heat"]))


def test_heat_taken_for_a_reading_is_confused():
    case = one("sensor_lag", ROADS[0])
    assert confused(case, Outcome(EFFECT, ["churning"]))
    assert not confused(case, Outcome(EFFECT, ["board_drift"]))
    assert not confused(case, Outcome(NOTHING))


def test_what_is_composed_must_sit_where_heat_was_drawn_and_may_follow_a_rival():
    case = asked(["drawn", "healthy", "0"])[0]
    shape = drawn(case.seed)
    near = Outcome(NOTHING, composed=["heat_at1"], place_mm=shape.place_mm + 50.0, follows="always")
    assert right(case, near)
    assert not right(case, replace(near, place_mm=shape.place_mm - 70.0))
    assert not right(case, replace(near, composed=()))
    follows = DRAWN[shape.kind]
    assert follows_drawn(case, replace(near, follows=follows[0]))
    assert follows_drawn(case, replace(near, follows="time", as_well=[follows[-1]]))
    assert not follows_drawn(case, replace(near, follows="time"))


def test_without_a_catalogue_half_of_the_gain_must_be_reached():
    case = asked(["bare", "healthy", "0"])[0]
    out = Outcome(NOTHING, before=(0.5, 4.0), after=(0.2, 1.0), knowing=(0.1, 0.5))
    assert gained(out) == pytest.approx([0.75, 3.0 / 3.5])
    assert right(case, out)
    assert not right(case, replace(out, after=(0.4, 1.0)))
    assert right(case, replace(out, before=(0.11, 0.55), after=(0.11, 0.55))), "there was nothing to gain"
