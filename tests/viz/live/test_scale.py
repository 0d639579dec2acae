"""Ranges and colours that hold while a run goes on."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.viz.live.conftest import Fed
from tests.viz_read import rows
from viz.live.live import LiveViews
from viz.live.scale import Decades, Growing


def test_a_broken_thermometer_does_not_stretch_the_frame(fed: Fed, tmp_path: Path) -> None:
    views = LiveViews(fed.run.rig, "FS-20", port=None, save=tmp_path / "x.rrd")
    for sample, step in fed.ticks[:60]:
        measured, fused = step.measured.copy(), step.fused.copy()
        measured[3], fused[3] = 190.0, False
        views.show(sample, replace(step, measured=measured, fused=fused))
    views.close()
    labels = rows(tmp_path / "x.rrd", "/FS-20/profile/axes/y", "Points2D:labels")[1]
    assert "190 °C" not in labels[-1]
    assert views.trouble == ""


def test_a_range_grows_ahead_of_its_values_and_seldom() -> None:
    growing, found = Growing(5.0), set()
    for value in np.linspace(20.0, 60.0, 400):
        low, high = growing.hold([np.array([20.0, value, np.nan])])
        assert low <= 20.0
        assert high >= value
        found.add((low, high))
    assert len(found) < 15
    assert high - low < 1.5 * 40.0
    assert Growing(5.0).hold([np.array([np.nan])]) is None


def test_colours_of_a_map_show_small_and_large_alike() -> None:
    scale = Decades.of(np.full((10, 3), 0.03))
    assert scale.finest == pytest.approx(0.005)
    np.testing.assert_allclose(scale.shares(np.array([0.004, 0.05, -0.5, np.nan])), [0.0, 0.5, -1.0, np.nan])
    assert scale.labels == ["-0.5 K", "-0.05 K", "±0.005 K", "+0.05 K", "+0.5 K"]
