"""Drawings: what is drawn of long curves, and that a gap stays one."""

import numpy as np

from ballscrew.page.curves import COLD, WARM, colours
from ballscrew.page.picture import BINS, curve, dots, sheet, shown


def test_of_a_long_curve_its_extremes_ends_and_gaps_are_drawn():
    values = np.sin(np.arange(50_000) / 9.0)
    values[12_345], values[31_000] = 7.0, -7.0
    values[20_000:20_500] = np.nan
    at = shown(values)
    assert len(at) <= 2 * BINS + 3
    assert {0, 12_345, 20_000, 31_000, 49_999} <= set(at.tolist())
    assert np.flatnonzero(np.isnan(values[at])).size == 1


def test_a_short_curve_is_drawn_whole_but_for_what_is_unknown():
    values = np.array([np.nan, 1.0, np.nan, np.nan, 2.0])
    np.testing.assert_array_equal(shown(values), [1, 2, 4])
    assert len(shown(np.full(3, np.nan))) == 0


def test_a_gap_breaks_the_line():
    with sheet(2.0) as drawn:
        axes = drawn.figure.subplots()
        curve(axes, np.arange(6.0), np.array([0.0, 1.0, np.nan, 3.0, 4.0, 5.0]), "filter", "a")
        dots(axes, np.arange(6.0), np.full(6, np.nan), "reading", "none")
        (line, _) = axes.lines
        assert np.isnan(line.get_ydata()).sum() == 1
    assert drawn.svg.startswith("<svg")


def test_nothing_lets_the_page_show_through():
    map_of = colours()
    assert map_of[len(map_of) // 2, 3] == 0
    np.testing.assert_allclose(map_of[[0, -1]], [[*COLD, 1], [*WARM, 1]])
