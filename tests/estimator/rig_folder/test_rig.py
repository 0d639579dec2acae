"""The rig: the paper's geometry, shares of cells, and rig files that say something wrong."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy import special

from estimator.errors import SetupError
from estimator.rig import Rig
from estimator.rig_folder.rig_folder import load_rig
from estimator.screw import Screw

SPACINGS = (72.5, 54.5, 144, 144, 144, 144, 84, 30, 30, 24, 18, 15.5, 20, 55.5)  # eq. (1), channel 1 to 15
SMALL = 'name = "bar"\n[channels]\nA = { at_mm = 10.0 }\nB = { at_mm = 90.0 }\n'
SCREW = "[screw]\nfrom_mm = 0.0\nto_mm = 100.0\nouter_mm = 20.0\n"
BAR = Screw(-50, 1030, 40, 17, cells=37)
PLACE = st.floats(-200, 1200)


def load(folder: Path, text: str) -> Rig:
    (folder / "rig.toml").write_text(text)
    return load_rig(folder)


def test_thermometers_stand_as_the_paper_says(rig):
    places = [rig.channels[name].at_mm for name in rig.thermometers]
    assert len(places) == 15
    np.testing.assert_allclose(np.diff(places), SPACINGS)
    assert places[-1] == 980.0
    assert rig.names[15] == "displacement"
    assert not rig.channels["displacement"].is_thermometer
    assert (rig.channels["T02"].at_mm, rig.channels["T12"].at_mm) == (
        rig.supports["free"].at_mm,
        rig.supports["anchor"].at_mm,
    )


def test_geometry_is_the_paper_s(rig):
    screw = rig.screw
    assert screw.area == pytest.approx(1029.66e-6, rel=1e-4)
    assert screw.area * screw.density * screw.heat_capacity == pytest.approx(3799, rel=1e-3)  # J/K per metre
    assert np.diff(screw.span_mm)[0] == pytest.approx(935.5)
    assert screw.growth(*screw.span_mm).sum() == pytest.approx(11.226, rel=1e-9)  # um/K
    assert screw.surface * screw.cells == pytest.approx(np.pi * 0.04 * 1.08)
    assert screw.relative_speed(np.array(1667 * 2 * np.pi / 60)) == pytest.approx(1.0)


def test_the_wall_of_the_bore_is_below_the_section_where_heat_goes_on_along_the_axis():
    """Heat q cos(w x) into the outside of a hollow bar, none into its bore: T = A I0(w r) + B K0(w r), times cos(w x),
    with dT/dr = 0 at the bore."""
    a, b, w = BAR.bore_mm / 2, BAR.outer_mm / 2, 2 * np.pi / 250.0
    radius = np.linspace(a, b, 4001)
    T = special.i0(w * radius) + special.i1(w * a) / special.k1(w * a) * special.k0(w * radius)
    mean = np.trapezoid(T * 2 * radius, radius) / (b**2 - a**2)
    assert 1 - w**2 * BAR.bore_mm2 == pytest.approx(T[0] / mean, abs=2e-4)
    assert 1 - T[0] / mean > 0.01
    assert replace(BAR, bore_mm=0.0).bore_mm2 == 0.0


def test_the_nut_goes_where_the_paper_heats(rig):
    half = rig.nut.length_mm / 2
    for (lo, hi), (begin, end) in {(0, 400): (186, 761), (130, 243): (343, 631), (202, 315): (271, 559)}.items():
        assert rig.nut.centre(np.array(hi)) - half == pytest.approx(begin, abs=0.51)
        assert rig.nut.centre(np.array(lo)) + half == pytest.approx(end, abs=0.51)


@given(PLACE, PLACE)
def test_overlap_is_the_length_inside(a, b):
    lo, hi = min(a, b), max(a, b)
    share = BAR.overlap(lo, hi)
    assert ((share >= 0) & (share <= 1 + 1e-12)).all()
    inside = max(0.0, min(hi, 1030) - max(lo, -50))
    assert share.sum() * BAR.length * 1e3 == pytest.approx(inside, abs=1e-9)
    assert (share[(BAR.edges_mm[1:] <= lo) | (BAR.edges_mm[:-1] >= hi)] == 0).all()


@given(PLACE, PLACE, PLACE)
def test_overlaps_of_neighbours_add_up(a, b, c):
    lo, mid, hi = sorted((a, b, c))
    np.testing.assert_allclose(BAR.overlap(lo, mid) + BAR.overlap(mid, hi), BAR.overlap(lo, hi), atol=1e-9)


@given(st.lists(PLACE, min_size=1, max_size=4))
def test_overlap_of_many_is_that_of_each(places):
    lo = np.array(places)
    np.testing.assert_array_equal(BAR.overlap(lo, lo + 175), [BAR.overlap(x, x + 175) for x in places])


@given(st.floats(BAR.x_mm[0], BAR.x_mm[-1]), st.floats(-3, 3), st.floats(-30, 30))
def test_at_reads_a_straight_profile_exactly(x, slope, level):
    assert BAR.at(x) @ (level + slope * BAR.x_mm) == pytest.approx(level + slope * x, abs=1e-8)


@given(PLACE)
def test_at_is_a_mean_of_neighbours(x):
    weights = BAR.at(x)
    assert weights.sum() == pytest.approx(1)
    assert ((weights >= 0) & (weights <= 1)).all()
    assert np.ptp(np.flatnonzero(weights)) <= 1


def test_a_screw_without_a_span_is_measured_whole(tmp_path):
    rig = load(tmp_path, SMALL + SCREW)
    assert rig.screw.span_mm == (0.0, 100.0)
    assert (rig.tick_s, rig.nut, rig.inputs, rig.subset_7) == (1.0, None, {}, ())
    assert rig.thermometers == ("A", "B")


def test_the_stroke_is_where_the_nut_is_between_the_bearings(rig):
    low, high = rig.stroke_mm
    half = rig.nut.length_mm / 2
    assert rig.nut.centre(np.array(low)) + half == pytest.approx(rig.supports["anchor"].at_mm)
    assert rig.nut.centre(np.array(high)) - half == pytest.approx(rig.supports["free"].at_mm)
    held = replace(rig, supports={"anchor": rig.supports["anchor"]})
    assert rig.nut.centre(np.array(held.stroke_mm[1])) - half == pytest.approx(rig.screw.from_mm)


@pytest.mark.parametrize("lacking", [{"screw": None}, {"nut": None}, {"supports": {}}, {"inputs": {}}], ids=str)
def test_without_any_of_its_parts_there_is_no_stroke(rig, lacking):
    assert replace(rig, **lacking).stroke_mm is None


def test_two_signals_or_one(rig):
    assert rig.channels["T03"].signals == ("Telemeter1.T03",)
    assert rig.channels["displacement"].signals == ("DisplacementHold.DspHoldA1B1", "DisplacementHold.DspHoldA2B2")


def test_fingerprint_tells_geometry_and_material_from_the_rest(rig):
    same = replace(rig, name="other", tick_s=2.0)
    assert same.fingerprint() == rig.fingerprint()
    for key, value in {"expansion_tolerance": 0.05, "cells": 50, "knots_mm": (0.0, 500.0)}.items():
        assert replace(rig, screw=replace(rig.screw, **{key: value})).fingerprint() == rig.fingerprint(), key
    for other in (
        replace(rig, screw=replace(rig.screw, expansion=11e-6)),
        replace(rig, screw=None),
        replace(rig, screw=replace(rig.screw, conductivity=45.0)),
        replace(rig, nut=replace(rig.nut, length_mm=170.0)),
        replace(rig, supports={}),
    ):
        assert other.fingerprint() != rig.fingerprint()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (SMALL + "[screew]\n", " has no 'screew'; did you mean 'screw'?"),
        ("[channels]\n", ": 'name' is missing"),
        ('name = "x"\n', ": 'channels' is missing"),
        ('name = "x"\nchannels = 3\n', ": channels: expected one table per name"),
        ('name = "x"\n[channels]\nA = 3\n', ": channels.A: expected a table with signal, column, unit, scale, offset, "
         "lo, hi, fresh, valid, at_mm, node"),
        (SMALL + "C = { at_m = 3 }\n", ": channels.C has no 'at_m'; did you mean 'at_mm'?"),
        (SMALL + 'C = { at_mm = "3" }\n', ": channels.C.at_mm: expected a number, got '3'"),
        (SMALL + "C = { unit = 3 }\n", ": channels.C.unit: expected str, got 3"),
        (SMALL + "C = { fresh = 3 }\n", ": channels.C.fresh: expected str, got 3"),
        (SMALL + "[inputs]\nair = { coloumn = 'x' }\n", ": inputs.air has no 'coloumn'; did you mean 'column'?"),
        (SMALL + SCREW.replace("outer_mm = 20.0\n", ""), ": screw: 'outer_mm' is missing"),
        (SMALL + SCREW + "cells = 10.5\n", ": screw.cells: expected int, got 10.5"),
        (SMALL + SCREW + "knots_mm = 5\n", ": screw.knots_mm: expected a list in [ ], got 5"),
        (SMALL + SCREW + 'knots_mm = [0, "a"]\n', ": screw.knots_mm: expected a number, got 'a'"),
        ("subset_7 = 5\n" + SMALL, ": subset_7: expected a list in [ ], got 5"),
        ("subset_7 = [5]\n" + SMALL, ": subset_7: expected str, got 5"),
        (SMALL + "[nut]\nlength_mm = 10\n", ": nut: 'centre_mm' is missing"),
        (SMALL + "[supports]\nfree = { at_mm = 5 }\n", ": supports.free: 'width_mm' is missing"),
        (SMALL + "[log]\ntime_colum = 't'\n", ": log has no 'time_colum'; did you mean 'time_column'?"),
    ],
)  # fmt: skip
def test_what_a_rig_file_gets_wrong_is_named(tmp_path, text, message):
    with pytest.raises(SetupError) as caught:
        load(tmp_path, text)
    assert str(caught.value) == f"{tmp_path / 'rig.toml'}{message}"


def test_the_file_stands_for_its_folder(rig):
    assert load_rig(rig.folder / "rig.toml") == rig


def test_a_missing_rig_and_an_unknown_channel_are_named(tmp_path, rig):
    with pytest.raises(SetupError) as caught:
        load_rig(tmp_path)
    assert str(caught.value) == f"{tmp_path / 'rig.toml'}: no such file"
    with pytest.raises(SetupError) as caught:
        rig.index("T7")
    assert str(caught.value) == f"{rig.folder / 'rig.toml'}: no channel 'T7'; did you mean 'T07'?"
    assert rig.index("T07") == 6
