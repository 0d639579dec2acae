"""What is in a saved file: read back with the reader of the format, no viewer needed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader
from scipy.stats import chi2

from estimator.errors import InputError
from tests.viz_read import fixed, pixels, rows, view_names
from viz.drawing import profile, screw
from viz.drawing.file import distinct, opens_at
from viz.drawing.scale import DIVERGING, coloured, minutes
from viz.lanes.standing import Judged
from viz.recorded import accuracy, misfits
from viz.recorded.recorded import save
from viz.recorded.run import ReviewedRun

SECONDS = 700


UNUSED = "Channels that are not used all the time"


def test_filter_and_its_band_are_the_tracks(saved: Path, run: ReviewedRun) -> None:
    time_s, values = rows(saved, "/FS-20/elongation/filter", "Measurements:values")
    variances = rows(saved, "/FS-20/elongation/filter", "Measurements:variances")[1]
    np.testing.assert_allclose(time_s, run.track.time_s)
    np.testing.assert_allclose(np.ravel(values), run.track.elongation_um)
    np.testing.assert_allclose(np.sqrt(np.ravel(variances)), 2 * run.track.sigma_um)


def test_the_smoothed_elongation_stands_beside_the_filter_s_with_its_own_band(saved, run):
    values = rows(saved, "/FS-20/elongation/smoothed", "Measurements:values")[1]
    variances = rows(saved, "/FS-20/elongation/smoothed", "Measurements:variances")[1]
    np.testing.assert_allclose(np.ravel(values), run.smoothed_um)
    np.testing.assert_allclose(np.ravel(variances), (2 * run.smoothed_sd_um) ** 2)
    errors = rows(saved, "/FS-20/error/smoothed", "Scalars:scalars")[1]
    np.testing.assert_allclose(np.ravel(errors), run.errors_um["smoothed"])


@pytest.mark.parametrize(
    ("entity", "field", "columns"),
    [
        ("channels/temperature/1", "measured", slice(0, 8)),
        ("channels/temperature/2", "measured", slice(8, 15)),
        ("channels/innovation/1", "innovation", slice(0, 8)),
        ("channels/innovation/2", "innovation", slice(8, 15)),
    ],
)
def test_channels_are_the_tracks(saved: Path, run: ReviewedRun, entity: str, field: str, columns: slice) -> None:
    values = rows(saved, f"/FS-20/{entity}", "Scalars:scalars")[1]
    np.testing.assert_allclose(np.array(values), getattr(run.track, field)[:, columns])


def test_every_run_has_the_same_curves_below_its_own_name(saved: Path) -> None:
    first = rows(saved, "/FS-20/elongation/models", "Scalars:scalars")[1]
    second = rows(saved, "/CS_2.5/elongation/models", "Scalars:scalars")[1]
    np.testing.assert_array_equal(first, second)


def test_error_is_the_runs(saved: Path, run: ReviewedRun) -> None:
    values = rows(saved, "/FS-20/error/filter", "Measurements:values")[1]
    np.testing.assert_allclose(np.ravel(values), run.errors_um["filter"])


def test_profile_is_kept_every_ten_seconds_in_mm_and_degrees(saved: Path, run: ReviewedRun) -> None:
    time_s, strips = rows(saved, "/FS-20/profile/estimate", "LineStrips2D:strips")
    assert set(np.diff(time_s)[1:]) == {10.0}
    axes = profile.axes_of(run.rig, run.scale)
    k = int(np.flatnonzero(run.track.time_s == time_s[30])[0])
    mean, upper, lower = np.array(strips[30])
    np.testing.assert_allclose(mean[:, 0], run.track.x_mm, atol=1e-3)
    np.testing.assert_allclose(-mean[:, 1] / axes.y_unit, run.track.profile_C[k], atol=1e-4)
    np.testing.assert_allclose((lower - upper)[:, 1] / axes.y_unit, 4 * run.track.profile_sd_K[k], atol=1e-4)


def test_a_silent_thermometer_is_not_in_the_profile(saved: Path) -> None:
    time_s, points = rows(saved, "/FS-20/profile/measured", "Points2D:positions")
    assert {len(row) for t, row in zip(time_s, points, strict=True) if 610 <= t <= 639} == {14}
    assert {len(row) for t, row in zip(time_s, points, strict=True) if t < 600} == {15}


def test_screw_grows_away_from_its_anchor(saved: Path, run: ReviewedRun) -> None:
    time_s, scales = rows(saved, "/FS-20/screw/tube", "Transform3D:scale")
    shifts = rows(saved, "/FS-20/screw/tube", "Transform3D:translation")[1]
    k = int(np.flatnonzero(run.track.time_s == time_s[30])[0])
    stretch = scales[30][0][0]
    drawn_um = (stretch - 1) * 935.5e3 / screw.exaggeration(run.rig, run.scale)
    assert drawn_um == pytest.approx(run.track.elongation_um[k], rel=1e-4)
    assert 889.0 * stretch + shifts[30][0][0] == pytest.approx(889.0, abs=1e-2)


def test_nut_stands_where_the_rig_says(saved: Path, run: ReviewedRun) -> None:
    time_s, places = rows(saved, "/FS-20/screw/nut", "Transform3D:translation")
    k = int(np.flatnonzero(run.track.time_s == time_s[10])[0])
    assert places[10][0][0] == pytest.approx(673.5 - run.recording.inputs["position"][k], abs=1e-3)


def test_readings_are_drawn_apart(saved: Path, run: ReviewedRun) -> None:
    time_s, values = rows(saved, "/FS-20/elongation/readings", "Scalars:scalars")
    assert 8 < len(time_s) < 40
    at = np.searchsorted(run.track.time_s, time_s)
    np.testing.assert_allclose(np.ravel(values), run.readings_um[at])


def test_parallel_lines_go_through_the_extreme_errors(saved: Path, run: ReviewedRun) -> None:
    errors, unit = run.errors_um["filter"], accuracy.figure_of([run]).square.x_unit
    for name, error in (("highest", errors.max()), ("lowest", errors.min()), ("equal", 0.0)):
        sloping = np.array(fixed(saved, f"/accuracy/filter/{name}", "LineStrips2D:strips")[0]) / unit
        np.testing.assert_allclose(-sloping[:, 1] - sloping[:, 0], error, atol=1e-3)
    points = np.array(fixed(saved, "/accuracy/filter/runs/FS-20/square", "Points2D:positions")) / unit
    drawn = -points[:, 1] - points[:, 0]
    assert drawn.max() == pytest.approx(errors.max(), abs=1e-3)
    assert drawn.min() == pytest.approx(errors.min(), abs=1e-3)


def test_bands_are_in_the_table(saved: Path, run: ReviewedRun) -> None:
    text = fixed(saved, "/accuracy/bands", "TextDocument:text")[0]
    for estimate in ("filter", "polyline"):
        error = run.errors_um[estimate]
        assert f"**{np.nanmax(error) - np.nanmin(error):.2f}**" in text
    assert "| **all** | " in text
    assert "reference: truth" in text


def test_nis_has_the_bounds_of_its_window(saved: Path, run: ReviewedRun) -> None:
    bounds = rows(saved, "/FS-20/nis/bounds", "Scalars:scalars")[1]
    ratios = rows(saved, "/FS-20/nis/window", "Scalars:scalars")[1]
    second = slice(60, 120)
    count = run.track.nis_channels[second].sum()
    np.testing.assert_allclose(sorted(bounds[1]), chi2.ppf([0.025, 0.975], count) / count)
    assert ratios[1][0] == pytest.approx(run.track.nis[second].sum() / count)


def test_map_has_a_row_for_each_thermometer_and_a_pixel_for_each_minute(saved: Path, run: ReviewedRun) -> None:
    drawn = pixels(saved, "/FS-20/residual/innovation/picture")
    assert drawn.shape == (15, -(-SECONDS // 60), 3)
    means = minutes(run.track.time_s, run.track.innovation[:, :15])[1]
    np.testing.assert_array_equal(drawn, coloured(means.T, run.scale.innovation_K, DIVERGING)[..., :3])
    assert fixed(saved, "/FS-20/residual/innovation/channels", "Points2D:labels") == list(run.rig.thermometers)
    wide, high, _ = fixed(saved, "/FS-20/residual/innovation/picture", "Transform3D:scale")[0]
    time_s, strips = rows(saved, "/FS-20/residual/innovation/now", "LineStrips2D:strips")
    assert time_s[3] == 181.0
    assert [place[0] for place in strips[3][0]] == pytest.approx([3.5 * wide] * 2)
    assert strips[3][0][1][1] == pytest.approx(15 * high)


def test_the_channel_that_surprises_most_is_named(run: ReviewedRun) -> None:
    found = misfits.surprises(replace(run, nis_of={**run.nis_of, "T04": 4.0, "T09": np.nan}))
    assert found.title == "Innovation / sd, rms [1]; worst T04: 2.00"
    assert found.rows == [name for name in run.rig.names if name != "T09"]
    assert found.series[0].values[3] == 2.0
    assert misfits.surprises(replace(run, nis_of=dict.fromkeys(run.rig.names, np.nan))).rows == ["none fused"]


def test_events_tell_what_happened(saved: Path) -> None:
    texts = [row[0] for row in rows(saved, "/FS-20/events", "TextLog:text")[1]]
    assert "0:00:21  drive starts" in texts
    assert "0:10:10  alarm: T07 at 703 mm is not read, since 0:10:00" in texts
    assert "0:10:41  over: T07 at 703 mm is not read" in texts
    assert "0:10:41  estimate valid no longer: no news of the drive" in texts
    assert "0:00:01  the log ends in the middle of a frame" in texts
    assert any(text.startswith("0:04:03  drive stops after 222 s at an elongation of ") for text in texts)


def test_lanes_say_whether_the_estimate_is_valid_and_what_is_broken_since_when(saved: Path) -> None:
    time_s, states = rows(saved, "/FS-20/state/estimate", "StateChange:state")
    told = list(zip(time_s, np.ravel(states), strict=True))
    assert [(t, s) for i, (t, s) in enumerate(told) if not i or s != told[i - 1][1]] == [
        (1.0, "no estimate yet"), (2.0, "valid"), (641.0, "no news of the drive"),
    ]  # fmt: skip
    time_s, states = rows(saved, "/FS-20/state/faults/silent", "StateChange:state")
    assert list(zip(time_s, np.ravel(states), strict=True)) == [(600.0, "T07"), (641.0, "")]


def test_a_well_run_has_the_lanes_of_every_run(run: ReviewedRun, tmp_path: Path) -> None:
    save(tmp_path / "well.rrd", [replace(run, judged=[Judged(1.0, (), ())])], "")
    paths = {str(chunk.entity_path) for chunk in RrdReader(tmp_path / "well.rrd").stream().to_chunks()}
    lanes = {path.removeprefix("/FS-20/state/") for path in paths if "/state/" in path}
    assert lanes == {"drive", "estimate", "mode", "thermometers"}
    assert not any(np.ravel(rows(tmp_path / "well.rrd", "/FS-20/profile/faults", "Points2D:labels")[1]))


def test_a_lane_that_says_something_new_keeps_its_colours(saved: Path) -> None:
    values = fixed(saved, "/FS-20/state/estimate", "StateConfiguration:values")
    colours = fixed(saved, "/FS-20/state/estimate", "StateConfiguration:colors")
    red = [value for value, colour in zip(values, colours, strict=True) if colour == colours[-1]]
    assert red == ["no news of the drive"]  # what is not yet is not lost
    assert len({*colours}) == 4  # with the lane that says nothing


def test_summary_is_the_callers(saved: Path) -> None:
    assert "given by the caller" in fixed(saved, "/summary", "TextDocument:text")[0]


def test_views_have_names_with_units(saved: Path) -> None:
    names = view_names(saved)
    assert len(names) == 4 + 2 * 25
    assert "Elongation [µm]" in names
    assert all("[" in name for name in names if name not in ("Summary", "At a glance", "Events", "State", UNUSED))


def test_a_rig_without_screw_has_no_profile(run: ReviewedRun, tmp_path: Path) -> None:
    bare = replace(run, rig=replace(run.rig, screw=None, nut=None, supports={}))
    save(tmp_path / "bare.rrd", [bare], "")
    assert not [name for name in view_names(tmp_path / "bare.rrd") if "screw" in name.lower()]


def test_a_thermometer_on_a_body_is_in_no_profile_and_neither_is_its_truth(run: ReviewedRun, tmp_path: Path) -> None:
    channels = {**run.rig.channels, "T15": replace(run.rig.channels["T15"], at_mm=None, node="nut")}
    save(tmp_path / "body.rrd", [replace(run, rig=replace(run.rig, channels=channels))], "")
    for what in ("measured", "truth"):
        points = rows(tmp_path / "body.rrd", f"/FS-20/profile/{what}", "Points2D:positions")[1]
        assert max(map(len, points)) == 14


def test_a_run_without_reference_is_saved_all_the_same(run: ReviewedRun, tmp_path: Path) -> None:
    nothing = np.full(len(run.track), np.nan)
    errors = dict.fromkeys(run.errors_um, nothing)
    blind = replace(run, readings_um=nothing, reference_um=nothing, errors_um=errors, truth_C_rise=None)
    save(tmp_path / "blind.rrd", [blind], "")
    names = view_names(tmp_path / "blind.rrd")
    assert "Elongation [µm]" in names
    assert not [name for name in names if "Error" in name or "Accuracy" in name]


def test_runs_of_one_name_stay_apart(run: ReviewedRun) -> None:
    assert [some.name for some in distinct([run, run, run])] == ["FS-20", "FS-20 (2)", "FS-20 (3)"]


def test_no_folder_is_said(run: ReviewedRun, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no folder"):
        save(tmp_path / "nowhere" / "x.rrd", [run], "")


def test_the_first_stop_is_the_moment_to_show(saved: Path, run: ReviewedRun) -> None:
    assert run.first_stop_s == 243.0
    assert opens_at(saved) == 243.0
