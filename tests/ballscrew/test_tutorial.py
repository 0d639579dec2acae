"""The tutorial: its notebook runs, and finds what was planted."""

import json
from pathlib import Path

import matplotlib as mpl
import pytest

from drivers.virtual_rig.machine.heaters import local_place

ROOT = Path(__file__).parents[2]


@pytest.mark.study
def test_the_notebook_finds_what_cools_the_machine_after_each_stop(monkeypatch):
    monkeypatch.chdir(ROOT)
    mpl.use("Agg")
    cells = json.loads((ROOT / "docs" / "tutorial.ipynb").read_text(encoding="utf-8"))["cells"]
    names: dict = {"__name__": "notebook"}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    assert names["found"].verdict == "nothing_in_catalogue"
    own = {path.partition(".")[2]: value for path, value in names["made"].hypothesis.own().items()}
    assert own["at"].value == pytest.approx(local_place(9, "slow_blast"), abs=20.0)
    assert own["power"].value == pytest.approx(-6.0, abs=3 * own["power"].sd)
    assert own["tau"].value == pytest.approx(900.0, abs=3 * own["tau"].sd)
    before, after = (one.open_loop_K for one in names["reviews"].values())
    assert after < 0.2 * before
    assert (names["folder"] / "held_out.png").stat().st_size > 5000
