"""What is in the views of a plant: read back with the reader of the format, no viewer needed."""

from pathlib import Path

import numpy as np

from tests.viz_read import fixed, pixels, view_names
from viz.drawing.scale import UNKNOWN, WARM
from viz.plant.plant import COLUMNS, ROWS, Figure, RigOverTime, save, worst_first

DAY_S = 86400.0
ERROR, NIS = Figure("Error", "rms", "µm"), Figure("NIS", "doublings", "1", signed=True)


def rig(name: str, error: float, first_day: int = 0, days: int = 10) -> RigOverTime:
    values = np.column_stack([np.linspace(0.1, error, days), np.full(days, -error)])
    return RigOverTime(name, 1.76e9 + DAY_S * (first_day + np.arange(days)), values)


PLANT = [rig("good", 0.1), rig("bad", 1.0, first_day=5, days=5), RigOverTime("lost", np.empty(0), np.empty((0, 2)))]


def test_the_worst_is_first_and_before_it_who_could_not_be_used() -> None:
    for figure in (0, 1):
        assert [PLANT[i].name for i in worst_first(PLANT, figure)] == ["lost", "bad", "good"]


def test_a_colour_lasts_until_the_next_recording(tmp_path: Path) -> None:
    save(tmp_path / "plant.rrd", PLANT, [ERROR, NIS], dated=True, summary="# By the caller")
    picture = pixels(tmp_path / "plant.rrd", "/plant/0/0/picture")
    assert picture.shape == (3, COLUMNS, 3)
    assert (picture[0] == UNKNOWN).all()
    assert (picture[1, : COLUMNS // 2] == UNKNOWN).all()
    assert tuple(picture[1, -1]) == WARM[-1]
    assert len(np.unique(picture[1, COLUMNS // 2 :], axis=0)) == 5
    names = fixed(tmp_path / "plant.rrd", "/plant/0/0/channels", "Points2D:labels")
    assert list(names) == ["lost", "bad", "good"]
    dates = fixed(tmp_path / "plant.rrd", "/plant/0/0/x", "Points2D:labels")
    assert len(dates) > 3
    assert all(date.startswith("2025-10-") for date in dates)


def test_more_rigs_than_a_page_holds_are_on_several(tmp_path: Path) -> None:
    many = [RigOverTime(f"axis-{n}", 1.0 + np.arange(3), np.full((3, 2), n / 10)) for n in range(ROWS + 2)]
    save(tmp_path / "plant.rrd", many, [ERROR, NIS], dated=False, summary="")
    assert len([name for name in view_names(tmp_path / "plant.rrd") if "worst lately first" in name]) == 4
    assert list(fixed(tmp_path / "plant.rrd", "/plant/0/1/channels", "Points2D:labels")) == ["axis-1", "axis-0"]
    assert list(fixed(tmp_path / "plant.rrd", "/plant/0/1/x", "Points2D:labels")) == ["1", "2", "3"]
