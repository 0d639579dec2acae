"""The sentences of a trend: what is odd of dates is named, and nothing is said to be steady that nobody has seen."""

import numpy as np
import pytest

from ballscrew.report.trend_report import sentences
from estimator.trend.course import Course
from estimator.trend.trend import Trend

DAYS = 1.7e9 + 86400.0 * np.arange(6.0)
NAMES = tuple("abcdef")
BOTH = frozenset({"rise", "step"})


def course(runs: int) -> Course:
    """Of six runs so many tell of it."""
    told = np.where(np.arange(6) < runs, 1.0, np.nan)
    return Course("nut_friction.power", "W", told, told)


def test_of_parameters_that_too_few_runs_tell_none_is_said_not_to_have_changed():
    (said,) = sentences(Trend(NAMES, DAYS, True, (), (course(5),), (), BOTH))
    assert said == "Whether a parameter has changed these 6 runs do not tell: of none do 6 know enough."
    (said,) = sentences(Trend(NAMES, DAYS, True, (), (course(6), course(5)), (), BOTH))
    assert said.endswith("of the 2 that the model leaves open, 1 are told by single runs.")


@pytest.mark.parametrize(
    ("start_s", "dated", "undated", "said"),
    [
        (np.sort(DAYS[[0, 1, 1, 3, 4, 5]]), True, (), "b, c begin at one instant, 2023-11-1"),
        (np.arange(6.0), False, ("c",), "c tells no date: all are taken in the order given"),
        (np.arange(6.0), False, NAMES, "These recordings tell no date: "),
        (np.arange(6.0), False, (), "These recordings all begin at one date: "),
    ],
)
def test_what_is_odd_of_dates_is_named(start_s, dated, undated, said):
    first, _ = sentences(Trend(NAMES, start_s, dated, undated, (course(6),), (), BOTH))
    assert first.startswith(said)


def test_what_so_few_runs_could_not_tell_is_not_said_to_be_absent():
    (said,) = sentences(Trend(NAMES, DAYS, True, (), (course(6),), (), frozenset()))
    assert (
        said
        == "These 6 runs are too few to tell that one of the 1 that the model leaves open has changed, however much."
    )
    _, said = sentences(Trend(NAMES, DAYS, True, (), (course(6),), (), frozenset({"rise"})))
    assert said == "A step so few runs do not tell, however large: a rise only."
