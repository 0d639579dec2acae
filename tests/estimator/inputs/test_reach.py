"""Which temperatures can drive heat at a place."""

import pytest

from estimator.inputs.follower import known_followers
from estimator.inputs.reach import reaches


@pytest.mark.parametrize(
    ("name", "places", "there"),
    [
        ("anchor_bracket", (0.0, 50.0), False), ("anchor_bracket", (800.0, 850.0), True),
        ("free_bracket", (0.0, 50.0), True),
        ("ambient", (0.0, 50.0), True), ("base", (800.0, 850.0), True), ("board", (400.0, 450.0), False),
        ("drive", (400.0, 450.0), True),
    ],
)  # fmt: skip
def test_a_temperature_far_away_drives_no_heat_but_air_and_base_do(rig, name, places, there):
    assert reaches(known_followers(rig)[name], rig, places) is there


def test_a_body_may_follow_any_support(rig):
    assert reaches(known_followers(rig)["anchor_bracket"], rig, ())
