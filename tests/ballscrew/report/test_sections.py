"""A value and how well it is known, as a person reads it."""

import pytest

from ballscrew.report.sections import with_sd
from estimator.model import Value


@pytest.mark.parametrize(
    ("value", "unit", "said"),
    [
        (Value(922.7, 46.0), "s", "923 +- 46 s"),
        (Value(375.2, 481.0), "mm", "375 +- 481 mm"),
        (Value(2.083, 0.21), "1", "2.1 +- 0.2"),
        (Value(-0.00123, 0.00042), "W/K", "-0.0012 +- 0.0004 W/K"),
        (Value(0.0351), "W", "0.0351 W"),
        (Value(0.0351, float("nan")), "1", "0.0351"),
    ],
)
def test_as_many_digits_as_are_known(value, unit, said):
    assert with_sd(value, unit) == said
