"""Heat on bodies that comes and goes within minutes is told, with both its times; where none does nothing is."""

from dataclasses import replace
from pathlib import Path

import pytest

import ballscrew
from estimator.batch.trials import unjudged
from estimator.effect import Effect, Param
from estimator.events.events import events
from estimator.terms import Heat
from estimator.work import Runs

FOLDER = Path(__file__).parents[3] / "examples" / "two_heaters"
OPENED_S, LASTS_S = ((600.0, 1200.0), 100.0)


class Lid(Effect):
    """A lid is opened twice."""

    power = Param(-0.5, "W", lo=-50.0, hi=50.0)

    def terms(self, p, u, rig):
        opened = sum((u.motion.time_s >= at_s) & (u.motion.time_s < at_s + LASTS_S) for at_s in OPENED_S)
        yield Heat("body_1", p.power * opened)


@pytest.fixture(scope="module")
def two_heaters():
    """The rig, its model and a recording."""
    rig = ballscrew.load_rig(FOLDER)
    return rig, ballscrew.load_model(FOLDER / "model.toml"), ballscrew.read(FOLDER / "both.csv", rig)


def test_a_lid_that_is_opened_is_told_each_time(two_heaters):
    rig, model, recording = two_heaters
    alone, opened = (unjudged(m, rig, recording).pose(m).run.lagged for m in (model, model + Lid))
    cooled = replace(recording, channels=recording.channels.copy())
    cooled.channels[1:] += opened - alone
    found = events(model, Runs(rig, [cooled]))
    assert [(event.kind, event.name) for event in found] == [("heat", "body_1")] * 2
    for event, at_s in zip(found, OPENED_S, strict=True):
        assert event.since_s == pytest.approx(at_s, abs=60.0)
        assert event.until_s == pytest.approx(at_s + LASTS_S, abs=60.0)
        assert event.heat_W == pytest.approx(-0.5, rel=0.3)
        assert "a lid or a door" in event.told()


def test_where_no_lid_is_opened_none_is_told(two_heaters):
    rig, model, recording = two_heaters
    assert events(model, Runs(rig, [recording])) == []
