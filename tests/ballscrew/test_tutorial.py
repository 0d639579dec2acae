"""The notebooks: they run, and find what was planted; what they have made prints as a person reads it."""

import json
from typing import Any

import matplotlib as mpl
import pytest

from drivers.virtual_rig.machine.heaters import local_place
from tests.conftest import ROOT


def run(name: str) -> dict[str, Any]:
    """What the cells of a notebook have made, by name; it keeps no outputs."""
    names: dict[str, Any] = {"__name__": "notebook"}
    for cell in json.loads((ROOT / "docs" / name).read_text(encoding="utf-8"))["cells"]:
        assert not cell.get("outputs")
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    return names


def test_the_first_steps_find_the_effect(monkeypatch):
    monkeypatch.chdir(ROOT)
    mpl.use("Agg")
    names = run("first-steps.ipynb")
    assert names["found"].verdict == "effect"
    assert names["found"].found[0].names == ("churning",)
    before, after = (one.whole["open_loop"].temperature_K for one in names["errors"])
    assert after < 0.2 * before
    shown = {
        name: repr(names[name]) for name in ("rig", "model", "held_out", "runs", "seen", "found", "better", "errors")
    }
    assert not [name for name, text in shown.items() if " at 0x" in text or len(text) > 10_000]
    assert "q = P |omega / omega_ref|^n" in shown["model"]
    assert "churning.share" in shown["found"]


@pytest.mark.study
def test_the_notebook_finds_what_cools_the_machine_after_each_stop(monkeypatch):
    monkeypatch.chdir(ROOT)
    mpl.use("Agg")
    names = run("tutorial.ipynb")
    assert names["found"].verdict == "nothing_in_catalogue"
    own = {path.partition(".")[2]: value for path, value in names["made"].hypothesis.own().items()}
    assert own["at"].value == pytest.approx(local_place(9, "slow_blast"), abs=20.0)
    assert own["power"].value == pytest.approx(-6.0, abs=3 * own["power"].sd)
    assert own["tau"].value == pytest.approx(900.0, abs=3 * own["tau"].sd)
    before, after = (one.open_loop_K for one in names["reviews"].values())
    assert after < 0.2 * before
    assert (names["folder"] / "held_out.png").stat().st_size > 5000
