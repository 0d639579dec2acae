"""What began within one run is told, and is taken for no effect and no wrong input."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.batch.trials import slow_trials_of
from estimator.effects import CATALOGUE
from estimator.events.event import HOT, LOOSE, READING, Event
from estimator.events.taken_out import taken_out
from estimator.missing_effect.suggest import suggest
from estimator.work import Runs
from tests.estimator.conftest import Chips


@pytest.fixture(scope="module")
def with_chips(plain, lives):
    """Three runs, chips in the second."""
    clean = lives(plain)
    return [clean[0], lives(plain + Chips)[1], clean[2]]


def test_what_began_is_told_and_nothing_else(plain, bar, with_chips):
    found = suggest(plain, Runs(bar, with_chips), CATALOGUE.values())
    (event,) = found.events
    assert (event.run, event.kind) == ("run 1", HOT)
    assert event.since_s == pytest.approx(Chips.since_s, abs=150.0)
    assert event.heat_W == pytest.approx(3.0, rel=0.3)
    assert (found.verdict, found.by_others, found.wrong_input) == ("nothing_in_catalogue", "nothing_missing", None)


def test_a_recording_without_its_event_is_what_it_would_have_been(plain, bar, lives, with_chips):
    clean, runs = lives(plain)[1], Runs(bar, [with_chips[1]])
    (trial,) = slow_trials_of(plain, runs)
    chips = Event("run 1", Chips.since_s, 60.0, HOT, from_mm=100.0, to_mm=150.0, heat_W=1.5)
    without = taken_out(runs.recordings[0], trial, plain, [chips, replace(chips, from_mm=150.0, to_mm=200.0)])
    before = np.nanstd(runs.recordings[0].channels - clean.channels)
    assert np.nanstd(without.channels - clean.channels) < 0.25 * before
    high = Event("run 1", Chips.since_s, 60.0, READING, channel="T2", offset=0.3)
    lowered = clean.channels - taken_out(clean, trial, plain, [high]).channels
    at = bar.index("T2")
    assert np.nanmax(np.abs(np.delete(lowered, at, axis=1))) == 0.0
    np.testing.assert_allclose(np.nan_to_num(lowered[:, at], nan=0.3)[clean.time_s > Chips.since_s + 10], 0.3)
    loose = Event("run 1", Chips.since_s, 60.0, LOOSE, channel="T2", share=-0.2)
    raised = taken_out(clean, trial, plain, [loose]).channels[:, at] - clean.channels[:, at]
    late = clean.time_s > Chips.since_s + 10
    rise = clean.channels[:, at] - np.nanmean(clean.channels[:10, at])
    np.testing.assert_allclose(np.nan_to_num(raised[late]), 0.2 * np.nan_to_num(rise[late]), atol=0.1 * np.nanmax(rise))
    assert np.nanmax(np.abs(raised[clean.time_s < Chips.since_s - 10])) == 0.0
