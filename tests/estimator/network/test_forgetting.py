"""What is forgotten of the regimes met: the one used longest ago, however old or new it is."""

from dataclasses import replace
from unittest import mock

import numpy as np
import pytest

from estimator.inputs.start import Start
from estimator.network import forcing as module, regime
from estimator.network.forcing import Forcing
from estimator.network.regime import Regimes

CELLS = 20


@pytest.fixture
def places(small, driven):
    """A parked machine: each place of its nut is a regime of its own."""
    run = driven(small, 4, (9, 9))
    covered = np.eye(4, CELLS, dtype=float) * 100.0
    return replace(run, coverage=covered, stay=covered)


def test_what_was_used_longest_ago_is_solved_again(small, small_model, places):
    forcing = Forcing(small_model, small, Start(22.0, 0.0, dict.fromkeys(small.inputs, 0.0)), keep=2)
    solved = []
    with mock.patch.object(module, "Modes", wraps=module.Modes) as modes:
        for place in (0, 1, 0, 2, 0, 1, 2, 0):
            forcing.ticks(forcing.read(places.rows(slice(place, place + 1))))
            solved.append(modes.call_count)
    # 0 was met first and stays, for it was used again; 1 makes room for it, and 0 for 2
    assert solved == [1, 2, 2, 3, 3, 4, 4, 5]


def test_a_regime_that_was_used_again_may_hold_again(monkeypatch):
    """Of three places two are remembered."""
    monkeypatch.setattr(regime, "REMEMBERED", 2)
    regimes = Regimes(1.0, forgets=True)
    here, there, elsewhere = np.eye(3, CELLS) * 100.0
    assert [regimes.index(0.0, place) for place in (here, there, here, elsewhere)] == [0, 1, 0, 2]
    assert len(regimes.met[1].coverage) == 0
    assert regimes.index(0.0, here) == 0
    assert regimes.index(0.0, there) == 3
    assert len(regimes.met[2].coverage) == 0
