"""Live views of rigs that lack something, and of runs of which nothing is known yet."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

from estimator.step import Mode, Step
from tests.viz.live.conftest import WAITING, Fed, show
from tests.viz_read import has_no_empty_chunk, rows, view_names
from viz.live.live import LiveViews


@pytest.mark.parametrize(
    "parts", [{"screw", "nut", "supports"}, {"nut"}, {"displacement"}], ids=lambda parts: "+".join(sorted(parts))
)
def test_rigs_that_lack_something_are_shown_all_the_same(fed: Fed, tmp_path: Path, parts: set[str]) -> None:
    rig, gone = fed.run.rig, {"screw": None, "nut": None, "supports": {}}
    rig = replace(rig, **{part: gone[part] for part in parts & gone.keys()})
    ticks = fed.ticks[:130]
    if "displacement" in parts:
        rig = replace(rig, channels={name: c for name, c in rig.channels.items() if name != "displacement"})
        ticks = [(replace(sample, channels=sample.channels[:-1]), shorter(step)) for sample, step in ticks]
    if "screw" in parts:
        none = {"profile_C": np.empty(0), "profile_sd_K": np.empty(0), "elongation_um": np.nan, "open_loop_um": np.nan}
        ticks = [(sample, replace(step, **none)) for sample, step in ticks]
    views = LiveViews(rig, "bare", port=0, save=tmp_path / "bare.rrd")
    show(views, ticks)
    views.close()
    assert views.trouble == ""
    names = view_names(tmp_path / "bare.rrd")
    assert any("Temperature along" in name for name in names) == ("screw" not in parts)
    assert any("over its stroke" in name for name in names) == ("nut" not in parts)
    assert any("displacement" in name.lower() for name in names) == ("displacement" not in parts)
    modes = {state for (state,) in rows(tmp_path / "bare.rrd", "/bare/state/mode", "StateChange:state")[1]}
    assert ("predict" in modes) == ("displacement" in parts)
    assert len(rows(tmp_path / "bare.rrd", "/bare/channels/temperature/1", "Scalars:scalars")[0]) == 130


def test_a_rig_on_which_nothing_moves_has_no_lane_of_driving(fed: Fed, tmp_path: Path) -> None:
    rig = replace(fed.run.rig, nut=None, inputs={})
    views = LiveViews(rig, "still", port=None, save=tmp_path / "still.rrd")
    show(views, fed.ticks[:60])
    views.close()
    lanes = {str(chunk.entity_path) for chunk in RrdReader(tmp_path / "still.rrd").stream().to_chunks()}
    assert "/still/state/mode" in lanes
    assert "/still/state/drive" not in lanes


def shorter(step: Step) -> Step:
    """A step without its last channel."""
    per_channel = ("names", "measured", "predicted", "innovation", "innovation_sd", "fused", "why", "open_loop")
    per_channel += ("fault", "since_s", "may_drift_K", "jump")
    mode = Mode.PREDICT if step.mode == Mode.UPDATE else step.mode
    return replace(step, mode=mode, **{name: getattr(step, name)[:-1] for name in per_channel})


def test_nothing_but_ticks_before_the_start_is_fine(fed: Fed, tmp_path: Path) -> None:
    assert {step.mode for _, step in fed.ticks[:WAITING]} == {Mode.INIT}
    views = LiveViews(fed.run.rig, "early", port=0, save=tmp_path / "early.rrd")
    show(views, fed.ticks[:WAITING], 1)
    views.close()
    assert views.trouble == ""
    assert has_no_empty_chunk(tmp_path / "early.rrd")
