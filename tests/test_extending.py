"""docs/extending.md says how to extend the program: every block of it is run."""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np

from ballscrew import cli
from drivers.budget import Budget
from drivers.frames import Tally
from drivers.logs import logs
from estimator.battery.battery import battery
from estimator.effect import Effect
from estimator.filter import Filter
from estimator.rig import Channel
from tests.conftest import PAPER, ballscrew, stepped
from tests.viz_fake import fake_run
from tests.viz_read import rows, view_names
from viz.drawing.file import saved
from viz.drawing.views import tabbed

PAGE = Path(__file__).parents[1] / "docs" / "extending.md"


def block(title: str) -> ModuleType:
    """The code below a title of the page, as a module."""
    text = PAGE.read_text(encoding="utf-8").partition(f"\n## {title}\n")[2]
    module = ModuleType(title.replace(" ", "_").lower())
    exec(re.search(r"```python\n(.*?)```", text, re.DOTALL)[1], vars(module))
    return module


def effect_of(module: ModuleType) -> type[Effect]:
    return next(v for v in vars(module).values() if isinstance(v, type) and issubclass(v, Effect) and v is not Effect)


def test_files_and_tests_that_the_page_names_are_there():
    named = re.findall(r"`((?:estimator|drivers|ballscrew|viz|tests)/[\w/]+\.py)(?:::(\w+))?`", PAGE.read_text())
    assert len(named) > 8
    for path, test in named:
        assert (f"def {test}(" if test else "import") in (PAGE.parents[1] / path).read_text(encoding="utf-8")


def test_an_effect(full, rig):
    findings = battery(effect_of(block("An effect")), full, rig)
    assert len(findings) > 5
    assert [finding for finding in findings if not finding.ok] == []


def test_a_sensor_kind(small, small_model, driven, live):
    laser = effect_of(block("A sensor kind"))
    rig = replace(small, channels={**small.channels, "laser": Channel(unit="um")})
    model = small_model + laser
    lived = live(model, rig, driven(rig, 60, (5, 40), stroke=(0.0, 100.0)), seed=1)
    track = stepped(Filter(model, rig), lived.recording)
    at = rig.index("laser")
    read = np.isfinite(lived.recording.channels[:, at])
    np.testing.assert_array_equal(track.fused[:, at], read)
    assert abs(track.innovation[read, at])[1:].max() < 1.0


def test_a_log_format(tmp_path, monkeypatch):
    module = block("A log format")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setitem(logs._READERS, ".pipe", (f"{module.__name__}:read_pipes", "lines with pipes"))
    path, tally = tmp_path / "run.pipe", Tally()
    path.write_text("0.010|210|0011223344556677\nnonsense\n0.020|211|ff\n")
    frames = logs.read_log(path, tally, Budget())
    assert frames.time.tolist() == [0.01, 0.02]
    assert frames.id.tolist() == [0x210, 0x211]
    assert frames.data[0].tolist() == [0x00, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77]
    assert tally.counts() == {"line that is no frame": 1}


def test_a_command(monkeypatch):
    monkeypatch.setitem(sys.modules, "ballscrew.commands.channels", block("A command"))
    monkeypatch.setitem(cli.COMMANDS, "channels", "Print the channels of a rig folder.")
    status, out, _ = ballscrew("channels", PAPER)
    assert (status, "T07" in out) == (0, True)
    assert json.loads(ballscrew("channels", PAPER, "--json")[1])["T06"] == 559.0


def test_a_view(tmp_path):
    run, module = fake_run("FS-20", 300), block("A view")
    path = tmp_path / "table.rrd"
    with saved(path, tabbed([module.page("FS-20", run.track)]), "FS-20", "", 243.0) as file:
        module.send(file / "FS-20", run.track)
    assert view_names(path) == ["Thermal error at the table [µm]"]
    values = rows(path, "/FS-20/error_at_table/filter", "Measurements:values")[1]
    known = np.isfinite(run.track.error_at_table_um)
    assert known.any()
    np.testing.assert_allclose(np.ravel(values), run.track.error_at_table_um[known])
