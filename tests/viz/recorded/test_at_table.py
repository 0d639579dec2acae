"""The error at the table over the stroke and over time, and what the filter leaves of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from estimator.step import TableErrors
from tests.viz_read import fixed, rows, view_names
from viz.recorded import at_table
from viz.recorded.recorded import save
from viz.recorded.run import ReviewedRun

AT = "/FS-20/at_table"


def test_the_error_over_the_stroke_has_its_band_and_the_truth(saved: Path, run: ReviewedRun) -> None:
    axes = at_table.axes_of(run)
    time_s, strips = rows(saved, f"{AT}/over_stroke/estimate", "LineStrips2D:strips")
    k = int(np.flatnonzero(run.track.time_s == time_s[20])[0])
    mean, upper, _ = np.array(strips[20])
    np.testing.assert_allclose(mean, axes.place(run.table.at_mm, run.table.error_um[k]), atol=1e-3)
    np.testing.assert_allclose((mean - upper)[:, 1] / axes.y_unit, 2 * run.table.sd_um[k], atol=1e-4)
    truth = np.array(rows(saved, f"{AT}/over_stroke/truth", "LineStrips2D:strips")[1][20][0])
    np.testing.assert_allclose(truth, axes.place(run.table.at_mm, run.table_truth_um[k]), atol=1e-3)
    table = rows(saved, f"{AT}/over_stroke/table", "Points2D:positions")[1][20][0]
    np.testing.assert_allclose(table, axes.place(run.recording.inputs["position"][k], axes.y[0]), atol=1e-3)


def test_over_time_stand_the_ends_of_the_stroke_and_its_middle(saved: Path, run: ReviewedRun) -> None:
    for i, at_mm in enumerate((0, 200, 400)):
        assert fixed(saved, f"{AT}/over_time/{i}", "Measurements:names") == [f"table at {at_mm} mm ±2 sd"]
        values = rows(saved, f"{AT}/over_time/{i}", "Measurements:values")[1]
        shown = np.arange(len(values)) * 10 - 1
        shown[0] = 0
        np.testing.assert_allclose(np.ravel(values), run.table.error_um[shown, i])
        left = np.ravel(rows(saved, f"{AT}/left/{i}", "Measurements:values")[1])
        np.testing.assert_allclose(left, -0.2, atol=1e-9)
        variances = rows(saved, f"{AT}/left/{i}", "Measurements:variances")[1]
        np.testing.assert_allclose(np.sqrt(np.ravel(variances)), 2 * run.table.sd_um[shown, i])


def test_without_a_truth_there_is_no_view_of_what_is_left_and_without_a_stroke_no_page(
    run: ReviewedRun, tmp_path: Path
) -> None:
    save(tmp_path / "blind.rrd", [replace(run, table_truth_um=None)], "")
    names = view_names(tmp_path / "blind.rrd")
    assert "Thermal error at the table [µm]" in names
    assert not [name for name in names if "leaves" in name]
    assert not at_table.is_known(replace(run, table=TableErrors.waiting(np.empty(0), len(run.track))))
