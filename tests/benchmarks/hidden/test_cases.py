"""The cases of the study of hidden effects: whose machine, which seed, what is hidden."""

import re
from collections import Counter

import pytest

from benchmarks import paper_rig
from benchmarks.hidden.cases import EVERY, ROADS, ROWS, Case, asked
from benchmarks.hidden.plants import BY_LAW, OWN, PLANTED, READINGS, STRANGERS, TAKEN_OUT, kind_of
from benchmarks.judged import JUDGED_ON
from drivers.virtual_rig.machine.heaters import LOCAL
from drivers.virtual_rig.machine.planted import strengths
from drivers.virtual_rig.population.draw import LAWS, machine
from estimator.effects import CATALOGUE
from estimator.hypotheses.candidates import kind_of as kind_in
from estimator.inputs.follower import all_followers

WHOLE = asked(["whole"])


def test_no_two_cases_share_a_seed():
    seeds = [case.seed for case in (*WHOLE, *asked(["whole", "dev"]))]
    assert len(set(seeds)) == len(seeds)


def test_machines_that_judge_have_set_nothing():
    for row in ROWS:
        machines = [case.machine for case in WHOLE if case.row == row]
        assert len(set(machines)) == len(machines)
        assert min(machines) > max(JUDGED_ON)
    assert {case.machine for case in asked(["whole", "dev"])} == set(range(1, 21))


def test_rows_are_as_large_as_their_intervals_ask_for():
    counts = Counter((case.row, case.road) for case in WHOLE)
    assert min(counts["one", road] for road in ROADS) >= 60
    assert {counts["none", road] for road in ROADS} == {40}
    assert min(counts.values()) >= 18


def test_the_smaller_study_meets_every_effect():
    small = asked([])
    assert {name for case in small if case.row == "one" for name in case.hidden.names} == set(EVERY)
    assert len(small) < len(WHOLE) / 8


def test_words_choose_rows_roads_and_cases():
    assert asked(["one", "same", "3-4", "dev"]) == [Case("one", "same", 3, True), Case("one", "same", 4, True)]
    assert {case.road for case in asked(["two", "shipped"])} == {"shipped"}
    with pytest.raises(SystemExit, match=re.escape("hidden: what is ones?")):
        asked(["ones"])


@pytest.mark.parametrize("row", ROWS)
def test_what_is_hidden_can_be(row):
    effects = set(paper_rig.model().effects)
    for case in WHOLE:
        if case.row == row:
            strengths(case.hidden.plant, ())
            assert set(case.hidden.taken) <= effects


def test_effects_are_of_the_kind_that_the_search_gives_them(rig):
    model = paper_rig.model("base")
    for name in EVERY:
        assert kind_of(name) == kind_in(model if name in model.effects else model + CATALOGUE[name], name, rig)
    assert set(READINGS) < set(PLANTED)
    assert not set(TAKEN_OUT) & set(PLANTED)


def test_strangers_are_local_and_follow_what_a_search_knows(rig):
    names = {follower.name for follower in all_followers(rig)}
    for name, follows in STRANGERS.items():
        assert name in LOCAL
        assert name not in CATALOGUE
        assert set(follows) <= names


def test_own_parameters_are_the_model_s_and_laws_the_machines():
    model, one = paper_rig.model(), machine(3)
    for paths in OWN.values():
        for path, of in paths.items():
            without, more = of(one)
            param = model.param(path)
            assert param.lo <= without < without + more <= param.hi
    assert set(BY_LAW) <= set(LAWS)
    assert set(BY_LAW.values()) <= set(CATALOGUE)
