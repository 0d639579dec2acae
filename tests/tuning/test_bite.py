"""The tuning tests bite: a model that was spoilt is found out, by the figure that shows it."""

from collections.abc import Callable

import pytest

from estimator.model import Model

from .compare import badness, better, digits, table, worse
from .measure import Figures, Folder

RUN, TICKS = "ES-20.blf", 1500  # not fitted; a drive and most of its rest


@pytest.fixture(scope="module")
def short(paper: Folder) -> Folder:
    """The paper's folder with the first part of a recording."""
    folder = Folder(paper.path)
    folder.keep(RUN, paper.recording(RUN).rows(slice(TICKS)))
    return folder


@pytest.fixture(scope="module")
def sound(short: Folder) -> Figures:
    return short.figures([RUN])


def scaled(model: Model, factor: float, chosen: Callable[[str], bool]) -> Model:
    return model.with_values({path: factor * model[path] for path in model.values if chosen(path)})


SPOILT = {  # factor, on what, and a figure of two channels that shows it
    "process noise 10 times larger": (
        10.0, lambda path: path.endswith(".noise"), {"all": "blind_nis", "T12": "whiteness"},
    ),
    "half of the thermometers' noise": (0.5, lambda path: path == "thermometers.sd", {"all": "in_2sd", "T08": "nis"}),
    "nut friction 20 % off": (
        0.8, lambda path: path == "nut_friction.power", {"thermometers": "open_loop_K", "displacement": "ahead_um"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SPOILT)
def test_a_spoilt_model_is_found_out(name: str, short: Folder, sound: Figures) -> None:
    """By its channels alone: no figure named here needs the truth."""
    factor, chosen, shown = SPOILT[name]
    now = short.figures_of(scaled(short.model, factor, chosen), RUN)
    found = {change.key: change for change in worse(sound, now)}
    for channel, figure in shown.items():
        change = found[RUN, channel, figure]
        line = [figure, RUN, channel, digits(sound[change.key]), digits(now[change.key])]
        assert line in [row.split()[:5] for row in table([*found.values()]).splitlines()]


def test_the_model_itself_is_not(sound: Figures) -> None:
    assert worse(sound, sound) == better(sound, sound) == []


@pytest.mark.parametrize(
    ("figure", "kept", "worst", "fine"),
    [
        ("nis", 1.2, 1.4, 0.81),
        ("nis", 0.8, 0.6, 1.2),
        ("whiteness", 0.05, 0.09, 0.01),
        ("in_2sd", 0.97, 0.985, 0.94),
        ("blind_in_2sd", 0.95, 0.8, 0.92),
        ("open_loop_K", 0.05, 0.054, 0.03),
        ("band_um", 0.30, 0.33, 0.1),
        ("truth_in_2sd", 0.99, 0.88, 0.92),
    ],
)
def test_worse_is_further_from_what_it_should_be(figure: str, kept: float, worst: float, fine: float) -> None:
    key = ("a.log", "T01", figure)
    assert [change.key for change in worse({key: kept}, {key: worst})] == [key]
    assert worse({key: kept}, {key: fine}) == []
    assert badness(key, worst) > badness(key, kept)


def test_a_figure_that_is_no_more_is_worse() -> None:
    lost = worse({("a.log", "T01", "nis"): 1.0}, {})
    assert table(lost).splitlines()[1].split() == ["nis", "a.log", "T01", "1.0", "none", "10%"]
