"""The polyline through the thermometers: eq. (1) by hand."""

from dataclasses import replace

import numpy as np
import pytest

from estimator.accuracy import polyline
from estimator.errors import SetupError

SPACINGS = np.array([72.5, 54.5, 144, 144, 144, 144, 84, 30, 30, 24, 18, 15.5, 20, 55.5])
PLACES = np.concatenate([[0], np.cumsum(SPACINGS)])
RISES = np.array([1.0, 4.0, 3.0, 2.5, 5.0, 4.5, 2.0, 2.2, 2.6, 3.5, 6.0, 8.0, 5.0, 3.0, 1.5])
RHO = 12e-3  # um per K and mm


def recording_of(rig, driven, rises: np.ndarray):
    """A recording whose channels start at temperatures of their own and then rise, one row a tick."""
    recording = driven(rig, 1 + len(rises))
    recording.channels[0, :15] = np.linspace(21, 23, 15)
    recording.channels[1:, :15] = recording.channels[0, :15] + rises
    return recording


def test_fifteen_channels_are_the_trapezoids_of_the_paper(rig, driven):
    """Over the whole 980 mm: 725/2 * (1 + 4) and so on, as eq. (1) has it."""
    whole = replace(rig, screw=replace(rig.screw, span_from_mm=0.0, span_to_mm=980.0))
    by_hand = RHO / 2 * sum(h * (a + b) for h, a, b in zip(SPACINGS, RISES[:-1], RISES[1:], strict=True))
    elongation = polyline.elongation(recording_of(whole, driven, RISES[None]), whole)
    np.testing.assert_allclose(elongation, [0, by_hand], atol=1e-9)


def test_the_span_begins_between_two_channels(rig, driven):
    """From 44.5 mm on: the piece up to channel 2 is 28 mm long and begins 44.5/72.5 of the way from channel 1."""
    begins = 1.0 + 3.0 * 44.5 / 72.5
    rest = sum(h * (a + b) for h, a, b in zip(SPACINGS[1:], RISES[1:-1], RISES[2:], strict=True))
    by_hand = RHO / 2 * (28.0 * (begins + 4.0) + rest)
    assert polyline.elongation(recording_of(rig, driven, RISES[None]), rig)[1] == pytest.approx(by_hand, abs=1e-9)


def test_seven_channels_leave_out_the_others_and_hold_the_outermost(rig, driven):
    """T02 T04 T05 T06 T08 T12 T15: from 44.5 to 72.5 mm the rise is T02's."""
    used = [1, 3, 4, 5, 7, 11, 14]
    x, y = np.append(44.5, PLACES[used]), np.append(4.0, RISES[used])
    by_hand = RHO * sum((b - a) * (c + d) / 2 for a, b, c, d in zip(x[:-1], x[1:], y[:-1], y[1:], strict=True))
    elongation = polyline.elongation(recording_of(rig, driven, RISES[None]), rig, rig.subset_7)
    assert elongation[1] == pytest.approx(by_hand, abs=1e-9)


def test_a_channel_beyond_the_span_counts_only_to_its_end(rig):
    short = replace(rig, screw=replace(rig.screw, span_from_mm=100.0, span_to_mm=200.0))
    weights = polyline.weights(short, ["T02", "T04"])
    far = ((100 - 72.5) + (200 - 72.5)) / 2 / 198.5  # mean share of T04 between 100 and 200 mm
    np.testing.assert_allclose(weights, RHO * 100 * np.array([1 - far, far]))


def test_uniform_rise_grows_the_span(rig):
    for names in (rig.thermometers, rig.subset_7, ("T07", "T02"), ("T05",)):
        assert polyline.weights(rig, names).sum() == pytest.approx(11.226)


def test_order_of_names_does_not_matter(rig):
    names = ["T12", "T04", "T08"]
    ordered = dict(zip(sorted(names), polyline.weights(rig, sorted(names)), strict=True))
    assert dict(zip(names, polyline.weights(rig, names), strict=True)) == pytest.approx(ordered)


def test_a_silent_thermometer_is_left_out_of_its_tick(rig, driven):
    recording = recording_of(rig, driven, np.array([RISES, RISES, RISES]))
    recording.channels[2, 6] = np.nan
    others = [name for name in rig.thermometers if name != "T07"]
    elongation = polyline.elongation(recording, rig)
    assert elongation[2] == pytest.approx(polyline.elongation(recording, rig, others)[2], abs=1e-12)
    assert elongation[1] == pytest.approx(elongation[3])
    assert abs(elongation[2] - elongation[1]) > 0.5


def test_a_thermometer_that_comes_late_is_left_out_of_all_ticks(rig, driven):
    """Silent for ten ticks, its rise is not known, and what it reads then must not bend the line."""
    recording = recording_of(rig, driven, np.outer(np.linspace(0, 1, 30), RISES))
    others = [name for name in rig.thermometers if name != "T07"]
    without = polyline.elongation(recording, rig, others)
    recording.channels[:10, 6] = np.nan
    np.testing.assert_allclose(polyline.elongation(recording, rig), without, rtol=0, atol=1e-12)


def test_a_thermometer_that_misses_the_first_tick_is_used(rig, driven):
    """Its rise counts from its own first reading."""
    recording = recording_of(rig, driven, np.array([0 * RISES, RISES, RISES]))
    whole = polyline.elongation(recording, rig)
    recording.channels[0, 6] = np.nan
    np.testing.assert_allclose(polyline.elongation(recording, rig)[1:], whole[1:], rtol=0, atol=1e-12)


def test_fewer_than_two_thermometers_make_no_line(rig, driven):
    recording = recording_of(rig, driven, np.array([RISES, RISES]))
    recording.channels[1, 1:15] = np.nan
    np.testing.assert_array_equal(np.isnan(polyline.elongation(recording, rig)), [False, True, False])
    assert np.isnan(polyline.elongation(recording, rig, ["T03"])).all()


def test_without_a_screw_it_says_what_is_missing(rig):
    with pytest.raises(SetupError, match=r"needs \[screw\], which paper's ball screw has not"):
        polyline.weights(replace(rig, screw=None), ["T01", "T02"])
