"""How sure the filter is: its error within two sd, the share inside, and readings used, not used, and at rest."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from estimator.inputs.phase import phase_of
from tests.viz_fake import fake_run
from tests.viz_read import fixed, rows, view_names
from viz.drawing import paths, series
from viz.recorded import sure
from viz.recorded.recorded import save
from viz.recorded.run import READINGS, ReviewedRun

SECONDS = 700


@pytest.fixture(scope="module")
def run() -> ReviewedRun:
    """Judged by readings, not used after 150 s; off by five sd while driving."""
    run = fake_run("FS-20", SECONDS)
    error, fused = 0.1 * run.error_sd_um, run.track.fused.copy()
    error[phase_of(run.recording) == "drive"] *= 50
    fused[150:, 15] = False
    errors = {**run.errors_um, "filter": error}
    return replace(run, reference_name=READINGS, errors_um=errors, track=replace(run.track, fused=fused))


@pytest.fixture(scope="module")
def saved(run: ReviewedRun, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sure") / "run.rrd"
    save(path, [run], "")
    return path


def test_the_share_inside_is_told_by_phase_and_red_where_it_falls_short(run: ReviewedRun) -> None:
    found = sure.shares(run)
    enough, short = found.series
    driving = (phase_of(run.recording) == "drive").mean()
    assert found.rows[:3] == ["all", "driving", "10 min after stops"]
    np.testing.assert_allclose(np.where(np.isnan(enough.values), short.values, enough.values)[:3], [1 - driving, 0, 1])
    assert short.colour == paths.LEFT_OUT
    np.testing.assert_array_equal(np.isfinite(short.values)[:3], [True, True, False])


def test_the_band_is_about_nothing_and_what_is_beyond_it_is_marked(run: ReviewedRun, saved: Path) -> None:
    at = "/FS-20/sure/error"
    variances = np.ravel(rows(saved, f"{at}/band", "Measurements:variances")[1])
    np.testing.assert_allclose(np.sqrt(variances), 2 * run.error_sd_um[np.isfinite(run.error_sd_um)], rtol=1e-6)
    assert not np.ravel(rows(saved, f"{at}/band", "Measurements:values")[1]).any()
    outside_s = rows(saved, f"{at}/outside", "Scalars:scalars")[0]
    np.testing.assert_array_equal(outside_s, run.track.time_s[phase_of(run.recording) == "drive"])
    low, high = sure._extent(run)
    assert low == -high
    assert high >= 2 * np.nanquantile(run.error_sd_um, 0.99)
    assert any("inside ±2 sd" in name and "[µm]" in name for name in view_names(saved))


def test_readings_used_and_not_used_and_the_dial_at_rest_are_three_things(run: ReviewedRun, saved: Path) -> None:
    at = "/FS-20/elongation"
    used_s, unused_s = (rows(saved, f"{at}/{name}", "Scalars:scalars")[0] for name in ("readings", "readings_unused"))
    assert used_s.max() <= 150.0 < unused_s.min()
    assert run.turning[np.searchsorted(run.track.time_s, unused_s)].all()
    time_s, level = rows(saved, f"{at}/dial", "Measurements:values")
    known = np.isfinite(np.ravel(np.array(level, dtype=float)))
    assert not run.turning[np.searchsorted(run.track.time_s, time_s[known])].any()
    assert fixed(saved, f"{at}/readings", "SeriesPoints:names") == [series.USED_READINGS]
    assert len(fixed(saved, f"{at}/readings_unused", "SeriesPoints:marker_sizes")) == 2  # a ring


def test_a_run_that_nothing_judges_shows_its_sd_alone(run: ReviewedRun, tmp_path: Path) -> None:
    nothing = np.full(SECONDS, np.nan)
    names = dict.fromkeys(run.errors_um, nothing)
    blind = replace(
        run, readings_um=nothing, level_um=nothing, level_sd_um=nothing, reference_um=nothing, errors_um=names
    )
    save(tmp_path / "blind.rrd", [blind], "")
    found = view_names(tmp_path / "blind.rrd")
    assert "Standard deviation [µm]" in found
    assert sure.TITLE not in found


def test_a_rig_without_an_elongation_has_no_such_view(run: ReviewedRun) -> None:
    nothing = np.full(SECONDS, np.nan)
    bodies = replace(run, error_sd_um=nothing, level_sd_um=nothing, track=replace(run.track, sigma_um=nothing))
    assert sure.is_known(run)
    assert not sure.is_known(bodies)
