"""Each effect of the virtual rig can be planted, scaled and taken away, and leaves its trace."""

import math
import re
from functools import partial

import numpy as np
import pytest

from drivers.virtual_rig import Run, simulate
from drivers.virtual_rig.machine.planted import BASE, PLANTED

minutes = partial(simulate, "FS-10", cycles=1, max_drive_s=60.0, stop_s=180.0)
"""A short drive and three minutes of rest: every effect leaves its trace there."""


@pytest.fixture(scope="module")
def base_minutes() -> Run:
    return minutes()


def trace(run: Run, base: Run) -> float:
    """How far all measured signals of a run lie from those of the base rig, root of the sum of squares."""
    pairs = [
        (run.measured.channels, base.measured.channels),
        (run.measured.direct.elongation_um, base.measured.direct.elongation_um),
        (run.holds.reading.elongation_um, base.holds.reading.elongation_um),
    ]
    return math.sqrt(sum(float(((a - b) ** 2).sum()) for a, b in pairs))


@pytest.mark.parametrize("effect", PLANTED)
def test_planted_effects_grow_with_their_strength(effect, base_minutes):
    runs = [minutes(plant={effect: strength}) for strength in (0.5, 2.0)]
    half, double = (trace(run, base_minutes) for run in runs)
    assert 0.1 < half < double
    assert runs[1].planted == {effect: 2.0}


@pytest.mark.parametrize("effect", BASE)
def test_base_effects_can_be_taken_away(effect, base_minutes):
    run = minutes(without={effect})
    assert trace(run, base_minutes) > 0.1
    assert run.planted == {effect: 0.0}


def test_reading_effects_leave_the_screw_alone(base_minutes):
    for effect in ("sensor_lag", "support_yield", "probe_expansion", "board_drift", "channel_offset", "channel_gain"):
        run = minutes(plant={effect: 2.0})
        assert np.array_equal(run.truth.elongation_um, base_minutes.truth.elongation_um)


def test_planted_places_are_told_and_depend_on_the_seed_alone():
    one, other = (simulate(name, seed=5, seconds=1.0, plant={"local_heat": 1.0}) for name in ("FS-20", "ES-5"))
    assert one.places == other.places
    assert 150.0 <= one.places["local_heat"] <= 780.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"plant": {"friction_thining": 1.0}}, "unknown effect 'friction_thining'; did you mean 'friction_thinning'?"),
        ({"without": {"still-air"}}, "unknown effect 'still-air'; did you mean 'still_air'?"),
        ({"plant": {"held_ends": -1.0}}, "plant 'held_ends': strength -1 is below 0, and no bearing's stiffness is"),
        ({"plant": {"radiation": math.nan}}, "plant 'radiation': strength nan is not a finite number"),
        ({"plant": {"radiation": 1.0}, "without": {"radiation"}}, "effect 'radiation' is both planted and taken away"),
    ],
)
def test_wrong_effects_are_named(options, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        simulate("FS-20", **options)


@pytest.mark.parametrize("name", ["FS20", "XS-20", "FS-fast", "FS-200", "CS-0"])
def test_wrong_experiments_are_named(name):
    with pytest.raises(ValueError, match=name):
        simulate(name)
