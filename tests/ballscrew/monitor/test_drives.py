"""Drives and stops as they come: told when they have lasted, from when they began."""

from dataclasses import replace

import numpy as np
import pytest

from ballscrew.monitor.drives import LASTS_S, Drives
from tests.viz_fake import DRIVE_S, REST_S, fake_run
from viz.recorded.run import ReviewedRun


@pytest.fixture(scope="module")
def run() -> ReviewedRun:
    return fake_run("FS-20", 300)


def told(run: ReviewedRun, omega: np.ndarray) -> list[tuple[float, float, str]]:
    """When something is told, since when it is so, and what."""
    drives, found = Drives(), []
    for k in range(len(run.track)):
        turn = drives.tick(replace(run.recording.sample(k), omega=float(omega[k])), run.track.step(k, ()))
        found += [(float(run.track.time_s[k]), turn.since_s, turn.text)] if turn else []
    return found


def test_a_drive_and_a_stop_are_told_with_what_has_grown(run):
    (now_s, since_s, start), (stop_now_s, stop_s, stop) = told(run, run.recording.omega)
    assert (now_s, since_s, start) == (REST_S + 1 + LASTS_S, REST_S + 1, "drive starts")
    assert (stop_now_s, stop_s) == (REST_S + DRIVE_S + 1 + LASTS_S, REST_S + DRIVE_S + 1)
    k = REST_S + DRIVE_S
    grown = f"{run.track.elongation_um[k]:.1f} ± {2 * run.track.sigma_um[k]:.1f} µm (2 sd)"
    alone = f"{run.track.open_loop_um[k]:.1f} by the model alone"
    assert stop == f"drive stops after {DRIVE_S} s at an elongation of {grown}, {alone}"


def test_a_rest_between_strokes_is_no_stop(run):
    omega = run.recording.omega.copy()
    omega[100 : 100 + int(LASTS_S) - 1] = 0.0
    assert [text.split()[1] for *_, text in told(run, omega)] == ["starts", "stops"]


def test_a_speed_that_is_not_known_changes_nothing(run):
    omega = run.recording.omega.copy()
    omega[100:150] = np.nan
    assert [since_s for _, since_s, _ in told(run, omega)] == [REST_S + 1, REST_S + DRIVE_S + 1]


def test_who_comes_in_the_middle_of_a_drive_does_not_say_how_long_it_was(run):
    omega = np.where(np.arange(300) < 200, 174.5, 0.0)
    ((_, since_s, text),) = told(run, omega)
    assert since_s == 201.0
    assert text.startswith("drive stops at an elongation of ")
