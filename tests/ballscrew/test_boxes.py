"""What a box's model lacks, as its owner asks for it."""

import json

import numpy as np

from tests.boxes import box, run
from tests.conftest import ballscrew


def test_a_lag_and_what_stores_heat_are_found_together(tmp_path):
    """Neither helps alone, and at its null the second one shows nothing of what it does."""
    box(tmp_path)
    ticks = np.arange(1200)
    switched = [(ticks % 300 < 60), (ticks < 500) & (ticks > 20), (ticks % 120 < 30) & (ticks < 900)]
    for name, heater in zip("abc", switched, strict=True):
        run(tmp_path / f"{name}.csv", heater, inside_J_K=540.0)
    status, out, _ = ballscrew("suggest", tmp_path, "--json", "--quiet")
    said = json.loads(out)
    assert (status, said["verdict"]) == (0, "effects")
    assert said["pair"] == ["sensor_lag", "inside"]
