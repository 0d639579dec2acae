"""Parameters that some recordings cannot tell from others are found, and left where they were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from estimator.errors import InputError
from estimator.fit.fit import fit
from estimator.fit.open_loop_fit import untold
from estimator.work import Runs

DICE = np.random.default_rng(3)


def columns(*each) -> np.ndarray:
    return np.stack(each, axis=-1)


def test_of_two_that_are_alike_the_first_is_kept():
    power, lag = DICE.standard_normal((2, 200))
    assert untold(columns(power, lag, -3 * power), ["power", "lag", "exponent"]) == {"exponent": "power"}
    assert untold(columns(-3 * power, lag, power), ["exponent", "lag", "power"]) == {"power": "exponent"}


def test_a_sum_of_others_is_like_the_one_it_holds_most_of():
    a, b, c = DICE.standard_normal((3, 200))
    assert untold(columns(a, b, c, 4 * a + b), ["a", "b", "c", "d"]) == {"d": "a"}


def test_one_without_influence_is_like_none():
    a, none = DICE.standard_normal(50), np.zeros(50)
    assert untold(columns(none, a), ["idle", "a"]) == {"idle": ""}
    assert untold(columns(none, none), ["idle", "too"]) == {"idle": "", "too": ""}


@pytest.mark.parametrize(("apart", "found"), [(0.1, {}), (0.005, {"b": "a"})])
def test_a_little_of_its_own_is_enough(apart, found):
    a, own = DICE.standard_normal((2, 5000))
    assert untold(columns(a, a + apart * own), ["a", "b"]) == found


def test_at_one_speed_a_fit_leaves_the_exponent_where_it_was(rig, full, driven, live):
    """Else it would move both anywhere; at two speeds both are found."""
    true = full.with_values({"nut_friction.power": 66.0, "nut_friction.n": 1.2})
    free = ("nut_friction.power", "nut_friction.power_nut", "nut_friction.n")
    loose = full.with_values({path: replace(value, fixed=path not in free) for path, value in full.values.items()})
    slow = live(true, rig, driven(rig, 400, (20, 240), 87.3), seed=5).recording
    fast = live(true, rig, driven(rig, 400, (20, 240), 174.5), seed=6).recording
    power, _, n = fit(loose, Runs(rig, [slow])).parameters
    assert n.value == loose["nut_friction.n"]
    assert n.like in free[:2]
    assert np.isnan(n.sd)
    at_slow = 66.0 * 0.5**1.2
    assert power.value * (87.3 / 174.5) ** n.value == pytest.approx(at_slow, rel=0.01)
    power, _, n = fit(loose, Runs(rig, [slow, fast])).parameters
    assert (power.value, n.value) == pytest.approx((66.0, 1.2), rel=0.02)
    assert not n.like


def test_recordings_that_say_nothing_of_a_parameter_are_refused(rig, full, driven, live):
    """At rest no friction shows; a noise level beside it is fitted all the same."""
    still = live(full, rig, driven(rig, 120, (120, 120)), seed=7).recording

    def loose(*free: str):
        return full.with_values({path: replace(value, fixed=path not in free) for path, value in full.values.items()})

    with pytest.raises(InputError, match=r"say nothing of nut_friction\.power, nut_friction\.n: free others"):
        fit(loose("nut_friction.power", "nut_friction.n"), Runs(rig, [still]))
    power, sd = fit(loose("nut_friction.power", "thermometers.sd"), Runs(rig, [still])).parameters
    assert power.value == full["nut_friction.power"]
    assert np.isfinite(sd.sd)
