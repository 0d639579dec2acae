"""How long the nut is at a place: only of ticks in which that is another coverage than by the angle turned."""

from __future__ import annotations

import numpy as np
import pytest

from estimator.stay import Stay

ANGLE = np.eye(6)[:, :4]
TIME = ANGLE + np.where(np.isin(np.arange(6), [1, 4])[:, None], 0.25, 0.0)


@pytest.fixture
def stay():
    time = TIME.copy()
    time[5] = np.nan
    return Stay.beside(ANGLE, time)


def test_what_is_the_same_or_not_known_is_not_kept(stay):
    assert stay.tick.tolist() == [1, 4]
    np.testing.assert_array_equal(stay.at(4), TIME[4])
    assert stay.at(0) is stay.at(5) is None


@pytest.mark.parametrize("which", [slice(1, 5), slice(4, None), slice(1, None, 3), slice(0, 0), slice(2, 4)])
def test_some_ticks_are_those_of_the_whole(stay, which):
    some, ticks = stay.rows(which, 6), np.arange(len(ANGLE[which]))
    np.testing.assert_array_equal(some.over(ANGLE[which], ticks), TIME[which])


def test_any_ticks_may_be_asked_for(stay):
    ticks = np.array([[4, 0], [1, 1]])
    np.testing.assert_array_equal(stay.over(ANGLE, ticks), TIME[ticks])
    np.testing.assert_array_equal(Stay().over(ANGLE, ticks), ANGLE[ticks])


def test_what_is_changed_is_changed_where_it_is(stay):
    np.testing.assert_array_equal(stay.each(lambda cover: 2 * cover).at(1), 2 * TIME[1])
    assert not len(Stay().each(lambda cover: cover[:, 7]).tick)
