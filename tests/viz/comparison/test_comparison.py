"""What is in the views of one or two models: read back with the reader of the format, no viewer needed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from estimator.rig import Rig
from tests.viz_read import fixed, has_no_empty_chunk, pixels, rows, view_names
from viz.comparison import heat
from viz.comparison.compared import ComparedRun, HeatAlong, HeatMap, Side
from viz.comparison.comparison import bars_at, save
from viz.comparison.maps import AFTER_ALONE, BROUGHT, HEAT, OPEN_LOOP, map_of, scales_of
from viz.drawing import paths
from viz.drawing.bars import Bars, BarSeries
from viz.drawing.file import opens_at
from viz.drawing.frames import ROW, WIDTH
from viz.drawing.scale import DIVERGING, coloured
from viz.viewer.printed import print_bars, print_heat, print_maps

SECONDS = 600
MODELS = "base.toml", "better.toml"
ERRORS = Bars(
    "rms of temperatures [K]",
    ["as given", "+ churning"],
    [
        BarSeries("cross-validated", np.array([0.6, 0.1]), paths.CROSS_VALIDATED),
        BarSeries("held out", np.array([0.5, np.nan]), paths.HELD_OUT),
    ],
)


def side(rig: Rig, off: float, bodies: tuple[str, ...] = ()) -> Side:
    """A model that misses the second channel by `off` in the second half, and lacks 10 off W/m there at 75 mm."""
    m = len(rig.names)
    late = np.arange(SECONDS) >= SECONDS // 2
    misfit = np.zeros((SECONDS, m))
    misfit[:, 1], misfit[::2, 4] = off * late, np.nan
    missing = np.zeros((10, 2))
    missing[5:, 1] = 10 * off
    body = np.full((10, len(bodies)), off)
    places = np.array([25.0, 75.0])
    phases = ["drive", "early_stop", *["late_stop"] * 8]
    lacks = HeatMap(np.arange(10) * 60.0, phases, places, missing, bodies, body)
    along = HeatAlong(places, {"driving": off * np.array([1.0, 3.0]), "at rest": np.zeros(2)}, dict.fromkeys(
        ("driving", "at rest"), np.array([0.5, 0.25])))  # fmt: skip
    level = np.full((SECONDS, m), 22.0)
    line = np.linspace(0.0, 10.0 - off, SECONDS)
    time_s = np.arange(SECONDS) + 1.0
    readings = np.where(np.arange(SECONDS) % 3 == 0, np.linspace(0, 10, SECONDS), np.nan)
    return Side(
        level - misfit, level, misfit / 10, line, np.full(SECONDS, 0.2), line, readings, time_s, misfit, lacks, along
    )


def compared(rig: Rig, name: str = "FS-20", sides: int = 2) -> ComparedRun:
    measured = np.full((SECONDS, len(rig.names)), 22.0)
    both = side(rig, 2.0), side(rig, -0.5)
    return ComparedRun(name, rig, np.arange(SECONDS) + 1.0, measured, both[:sides], (20.0, 60.0))


@pytest.fixture(scope="module")
def saved(small: Rig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two recordings in one file."""
    path = tmp_path_factory.mktemp("viz") / "two.rrd"
    runs = [compared(small), compared(small, "CS 2.5")]
    save(path, runs, MODELS, {"Errors": [ERRORS], "Channels": [ERRORS]}, "# By the caller")
    return path


def test_curves_of_a_thermometer_are_means_of_ten_seconds(saved: Path) -> None:
    at = "/FS-20/compared/temperature/T2"
    time_s, values = rows(saved, f"{at}/before", "Scalars:scalars")
    assert time_s[:2].tolist() == [6.0, 16.0]
    np.testing.assert_allclose(np.array(values)[[0, -1]], [[22.0, 22.0], [20.0, 22.0]])
    np.testing.assert_allclose(rows(saved, f"{at}/after", "Scalars:scalars")[1][-1], [22.5, 22.0])
    np.testing.assert_allclose(np.ravel(rows(saved, f"{at}/measured", "Scalars:scalars")[1]), 22.0)
    names = fixed(saved, f"{at}/before", "SeriesLines:names")
    assert names == ["before, open-loop [°C]", "before, filter [°C]"]


def test_elongation_has_both_models_and_the_readings(saved: Path) -> None:
    at = "/CS_2.5/compared/elongation"
    for name, end in (("before", 8.0), ("after", 10.5)):
        assert rows(saved, f"{at}/{name}/filter", "Measurements:values")[1][-1][0] == pytest.approx(end, abs=0.1)
        assert rows(saved, f"{at}/{name}/open_loop", "Scalars:scalars")[1][-1][0] == pytest.approx(end, abs=0.1)
    values = np.ravel(rows(saved, f"{at}/readings", "Scalars:scalars")[1])
    assert (values.min(), values.max()) == (0.0, pytest.approx(10.0, abs=0.5))


def test_maps_before_and_after_are_on_one_scale_and_after_also_on_its_own(saved: Path, small: Rig) -> None:
    run = compared(small)
    scales = scales_of([run])
    assert scales[OPEN_LOOP] == (-2.0, 2.0)
    assert scales[HEAT] == (-20.0, 20.0)
    own = {OPEN_LOOP: (-0.5, 0.5), HEAT: (-6.0, 6.0)}
    sides = (*zip(paths.SIDES, run.sides, strict=True), (AFTER_ALONE, run.sides[-1]))
    for what, values in ((OPEN_LOOP, (2.0, -0.5, -0.5)), (HEAT, (20.0, -5.0, -5.0))):
        for (name, one), value in zip(sides, values, strict=True):
            extent = own[what] if name == AFTER_ALONE else scales[what]
            drawn = pixels(saved, f"/FS-20/compared/{what}/{name}/picture")
            assert drawn.shape[:2] == map_of(run, one, what).values.T.shape
            assert tuple(drawn[1, -1]) == tuple(coloured(value, extent, DIVERGING)[:3])
            assert tuple(drawn[1, 0]) == DIVERGING[2]
    assert fixed(saved, "/FS-20/compared/heat/after/channels", "Points2D:labels") == ["25", "75"]
    assert fixed(saved, "/FS-20/compared/heat/after/bar_labels", "Points2D:labels")[0] == "-20 W/m"
    assert fixed(saved, "/FS-20/compared/heat/after_alone/bar_labels", "Points2D:labels")[0] == "-6 W/m"


def test_a_map_of_heat_says_what_the_machine_did_and_when(saved: Path) -> None:
    texts = fixed(saved, "/FS-20/compared/heat/before/x", "Points2D:labels")
    assert texts == ["D 0", "R 3", "R 6", "R 9"]


def test_heat_missing_over_the_screw_has_its_band_the_travel_and_both_models(saved: Path, small: Rig) -> None:
    run, at = compared(small), "/FS-20/compared/along/driving"
    axes = heat.frame_of(run, heat.curves(run)["driving"])
    for i, off in enumerate((2.0, -0.5)):
        strip = np.array(fixed(saved, f"{at}/curve/{i}", "LineStrips2D:strips")[0])
        np.testing.assert_allclose(strip, axes.place([25.0, 75.0], [off, 3 * off]), atol=1e-3)
        band = -np.array(fixed(saved, f"{at}/band/{i}", "LineStrips2D:strips")[0])[:, 1] / axes.y_unit
        assert band[:2] == pytest.approx([off - 1.0, off + 1.0], abs=0.1)
    np.testing.assert_allclose(fixed(saved, f"{at}/travel", "LineStrips2D:strips")[0], axes.place([20, 60], axes.y[0]))
    names = fixed(saved, f"{at}/key", "Points2D:labels")
    assert names[:3] == ["before ±2 sd", "after ±2 sd", "nut's travel"]


def test_what_added_effects_bring_stands_beside_what_is_missing_on_its_scale(small: Rig, tmp_path: Path) -> None:
    run = compared(small)
    before, after = run.sides
    more = np.zeros((10, 2))
    more[:5, 0] = 44.0
    more_heat = HeatMap(after.heat.time_s, after.heat.phases, after.heat.places_mm, more, ("nut",), np.ones((10, 1)))
    added = replace(run, sides=(before, replace(after, brought=more_heat)), added=("wiper", "jet"))
    assert scales_of([added])[HEAT] == scales_of([added])[BROUGHT] == (-60.0, 60.0)
    save(tmp_path / "more.rrd", [added], MODELS, {"Channels": [ERRORS]}, "")
    assert "heat that wiper and jet bring [W/m]" in view_names(tmp_path / "more.rrd")
    assert fixed(tmp_path / "more.rrd", "/FS-20/compared/brought/after/channels", "Points2D:labels") == ["25", "75"]
    legend = fixed(tmp_path / "more.rrd", "/FS-20/compared/bodies/brought", "SeriesLines:names")
    assert legend == ["that wiper and jet bring into nut [W]"]
    idle = replace(added, name="CS", sides=(before, replace(after, brought=replace(more_heat, W_m=0 * more))))
    print_heat(tmp_path / "heat.png", [idle, added], MODELS)
    print_heat(tmp_path / "plain.png", [run], MODELS)
    wide, plain = (np.asarray(Image.open(tmp_path / name)).shape[1] for name in ("heat.png", "plain.png"))
    assert wide > 1.1 * plain


def test_bars_begin_at_zero_and_carry_their_values(saved: Path) -> None:
    drawn = pixels(saved, f"/{bars_at('Errors', 0)}/picture")
    long = (drawn[ROW // 4] == paths.CROSS_VALIDATED).all(axis=-1)
    assert long[0]
    assert long.sum() == pytest.approx(WIDTH * 0.6 / ERRORS.end, abs=2)
    assert not (drawn[ROW + ROW // 2 + 5 :] == paths.HELD_OUT).all(axis=-1).any()
    assert fixed(saved, f"/{bars_at('Errors', 0)}/values", "Points2D:labels") == ["0.600 / 0.500", "0.100"]


def test_every_view_says_its_unit_and_its_model(saved: Path) -> None:
    names = view_names(saved)
    assert len(names) == 1 + 2 + 2 * (2 + 3 + 6 + 2 + 4)
    assert all("[" in name for name in names if name != "Summary")
    assert "after: thermometer − open-loop [K], better.toml" in names
    assert "before: heat missing [W/m], base.toml" in names


def test_summary_is_the_callers_and_the_end_is_the_moment(saved: Path) -> None:
    assert fixed(saved, "/summary", "TextDocument:text") == ["# By the caller"]
    assert opens_at(saved) == SECONDS


def test_one_model_is_called_by_its_name(small: Rig, tmp_path: Path) -> None:
    save(tmp_path / "one.rrd", [compared(small, sides=1)], MODELS[:1], {"Channels": [ERRORS]}, "")
    names = view_names(tmp_path / "one.rrd")
    assert "thermometer − open-loop [K], base.toml" in names
    legend = fixed(tmp_path / "one.rrd", "/FS-20/compared/temperature/T2/before", "SeriesLines:names")
    assert legend == ["open-loop [°C]", "filter [°C]"]


def test_heat_of_bodies_is_a_curve_and_nothing_known_leaves_no_empty_chunk(small: Rig, tmp_path: Path) -> None:
    one = side(small, 1.0, ("nut",))
    nothing = np.full((SECONDS, len(small.names)), np.nan)
    no_place = HeatMap(one.heat.time_s, one.heat.phases, np.empty(0), np.empty((10, 0)), ("nut",), one.heat.W)
    empty = {"at rest": np.empty(0)}
    nowhere = HeatAlong(np.empty(0), empty, empty)
    silent = Side(*[nothing] * 3, *[nothing[:, 0]] * 4, one.misfit_time_s, nothing, no_place, nowhere)
    run = ComparedRun("short", small, np.arange(SECONDS) + 1.0, nothing, (silent,))
    save(tmp_path / "short.rrd", [run], ["model"], {"Channels": [ERRORS]}, "")
    assert has_no_empty_chunk(tmp_path / "short.rrd")
    assert "Heat that the model alone lacks in nut [W]" in view_names(tmp_path / "short.rrd")
    assert not [name for name in view_names(tmp_path / "short.rrd") if "W/m" in name]


def test_printed_maps_show_the_same_colours(small: Rig, tmp_path: Path) -> None:
    print_maps(tmp_path / "maps.png", [compared(small)], MODELS)
    print_bars(tmp_path / "bars.png", [ERRORS, ERRORS])
    shades = {tuple(colour) for colour in np.asarray(Image.open(tmp_path / "maps.png").convert("RGB")).reshape(-1, 3)}
    assert {paths.BACKGROUND, DIVERGING[2], DIVERGING[-1]} <= shades
    shades = {tuple(colour) for colour in np.asarray(Image.open(tmp_path / "bars.png").convert("RGB")).reshape(-1, 3)}
    assert {paths.CROSS_VALIDATED, paths.HELD_OUT} <= shades
