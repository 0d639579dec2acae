"""Two coarse thermometers in a box whose model knows neither their lag nor its lid: none of them is broken."""

import numpy as np
import pytest

from drivers.recordings import read_recording
from estimator.accuracy.review import review
from estimator.filter import Filter
from estimator.rig_folder.model_toml import load_model
from estimator.rig_folder.rig_folder import load_rig
from tests.boxes import box, run

TICKS = np.arange(1500)


@pytest.mark.parametrize(("jump_K", "broken"), [(0.0, ["", ""]), (8.0, ["jumped", ""])])
def test_what_a_model_lacks_is_no_fault_of_few_thermometers_and_what_jumps_is(tmp_path, jump_K, broken):
    """Heat that comes a minute late, readings that stand still within a step, a lid: all others are said to be well."""
    rig, heater = load_rig(box(tmp_path)), (TICKS % 400 < 60) & (TICKS > 20)
    recording = read_recording(run(tmp_path / "run.csv", heater, lid=range(900, 940), jump_K=(1100, jump_K)), rig)
    assert {*recording.inputs["heater"]} == {0.0, 1.0}
    model = load_model(tmp_path / "model.toml")
    found, live = review(recording, rig, model), Filter(model, rig)
    use = found.use
    assert [one.spells[-1].fault.word if one.spells else "" for one in use.channels] == broken
    assert not use.again
    assert not use.jumps
    np.testing.assert_array_equal([live.step(sample).fault for sample in recording], found.track.fault)
