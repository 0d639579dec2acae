"""The recordings of a case: what is wrong in which of them."""

from functools import partial

import numpy as np
import pytest

from benchmarks.hidden import recorded as module
from benchmarks.hidden.cases import ODD, Case, asked
from benchmarks.hidden.recorded import Recorded, recorded
from drivers.virtual_rig import simulate


@pytest.fixture
def short(monkeypatch) -> None:
    """A minute and a half of driving, a minute of rest."""
    monkeypatch.setattr(module, "simulate", partial(simulate, cycles=1, max_drive_s=90.0, stop_s=60.0))


def with_one(row: str, **hidden: object) -> Case:
    """The first case of a row with these things hidden."""
    cases = asked([row, "whole", "healthy"])
    return next(c for c in cases if all(getattr(c.hidden, key) == value for key, value in hidden.items()))


def differ(case: Case, of: Recorded, rig, what: str) -> list[bool]:
    """Which recordings are others than those of the same case with nothing hidden."""
    plain = [module.record(module.simulate(name, machine=case.machine, seed=case.seed), rig) for name in case.runs[0]]
    return [not np.array_equal(get(a, what), get(b, what), equal_nan=True) for a, b in zip(plain, of.seen)]


def get(recording, what: str) -> np.ndarray:
    return recording.inputs[what] if what in recording.inputs else getattr(recording, what)


@pytest.mark.parametrize(
    ("case", "what"),
    [
        (with_one("label", position=1.0, ambient_K=0.0), "omega"),
        (with_one("label", position=1.2), "position"),
        (with_one("label", ambient_K=3.0), "ambient"),
        (with_one("sensor", fault="+2 K"), "channels"),
    ],
)
def test_one_recording_is_wrong_and_known(short, rig, case, what):
    of = recorded(case, rig)
    assert differ(case, of, rig, what) == [i == ODD for i in range(len(of.seen))]
    assert of.odd == of.seen[ODD].name
    assert not of.held_out


def test_the_position_is_off_in_all(short, rig):
    of = recorded(Case("shifted", "same", 0), rig)
    assert all(differ(Case("shifted", "same", 0), of, rig, "position"))


def test_something_begins_in_the_slowest_drive(short, rig):
    case = Case("event", "healthy", 0)
    of = recorded(case, rig)
    where = [i for i, each in enumerate(of.seen) if each.name == of.odd]
    assert differ(case, of, rig, "channels") == [i in where for i in range(len(of.seen))]
    assert of.odd in ("FS-5.blf", "ES-5.blf")
    assert 20.0 < of.onset_s < 110.0


def test_runs_are_held_out_where_the_error_afterwards_matters(short, rig):
    of = recorded(Case("one", "healthy", 8), rig)
    assert [len(of.seen), len(of.held_out)] == [4, 2]
    assert of.places.keys() == {"local_heat"}
