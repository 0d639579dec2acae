"""Of a machine that wears the right parameter is told, with the run; of one that does not, none."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from estimator.errors import InputError, SetupError
from estimator.hypotheses.moments import Moments
from estimator.trend.course import Known, directions
from estimator.trend.trend import trend
from estimator.work import Runs
from tests.estimator.conftest import Chips

WEAR = 1.15
SD = {"still_air.h": 0.3, "nut_friction.power": 1.0}


@pytest.fixture(scope="module")
def known(plain):
    """The model as a fit has left it: with what it knows of its parameters."""
    values = {path: replace(plain.values[path], sd=sd) for path, sd in SD.items()}
    return plain.with_values(values)


@pytest.fixture(scope="module")
def life(known, lives):
    """Twelve runs, one a day; the last four, which are handed over first, of a nut that is tight."""
    worn = known.with_values({"nut_friction.power": WEAR * known["nut_friction.power"]})
    runs = [*lives(known, 1), *lives(known, 11), *lives(worn, 21)]
    dated = [replace(run, name=f"day {k}", began_s=1.7e9 + 86400.0 * k) for k, run in enumerate(runs)]
    return [*dated[8:], *dated[:8]]


def test_the_parameter_that_has_changed_is_told_in_the_order_of_the_clocks(known, bar, life):
    found = trend(known, Runs(bar, life))
    assert found.names == tuple(f"day {k}" for k in range(12))
    assert found.dated
    assert [one.drift.course.name for one in found.told] == ["nut_friction.power"]
    drift = found.told[0].drift
    assert drift.run == 8
    assert drift.share == pytest.approx(WEAR - 1.0, abs=0.03)
    assert drift.p < 0.05


def test_a_machine_that_does_not_change_has_no_trend(known, bar, life):
    found = trend(known, Runs(bar, life[4:]))
    assert found.told == ()
    (course,) = (one for one in found.courses if one.name == "nut_friction.power")
    off = (course.value - known["nut_friction.power"]) / course.sd
    assert np.sqrt(np.mean(off**2)) < 2.0


def test_few_runs_are_refused(known, bar, life):
    with pytest.raises(InputError, match="needs 6 recordings of one machine at least; here are 5"):
        trend(known, Runs(bar, life[:5]))


def test_one_date_for_all_is_no_date(known, bar, life, monkeypatch):
    """Six runs whose misfits nobody asks for."""
    monkeypatch.setattr("estimator.trend.trend.MOST", 0)
    short = [replace(run, began_s=1.7e9).rows(slice(100)) for run in life[4:10]]
    assert not trend(known, Runs(bar, short)).dated


def test_two_runs_of_one_date_cost_the_others_nothing_and_one_without_a_date_is_named(known, bar, life, monkeypatch):
    twice = [replace(run, began_s=1.7e9) if run.name == "day 1" else run for run in life[:9]]
    found = trend(known, Runs(bar, twice))
    assert found.dated
    assert found.names == tuple(f"day {k}" for k in (0, 1, 2, 3, 4, 8, 9, 10, 11))
    assert [one.drift.course.name for one in found.told] == ["nut_friction.power"]
    monkeypatch.setattr("estimator.trend.trend.MOST", 0)
    short = [run.rows(slice(100)) for run in life[4:10]]
    without = trend(known, Runs(bar, [*short[:5], replace(short[5], began_s=None)]))
    assert (without.dated, without.undated) == (False, (life[9].name,))


def test_a_model_that_no_fit_has_left_an_sd_is_refused(plain, bar, life):
    with pytest.raises(SetupError, match="none of its parameters has an sd"):
        trend(plain, Runs(bar, life))


def test_a_parameter_that_neither_fit_nor_table_knows_is_not_told(known):
    """Of a run that has nothing to say of it either: no overflow, and no value to +-1000."""
    model = known + Chips
    size = len(model.free()) + 1
    sums = cast(list[Moments], [SimpleNamespace(weighted=np.zeros((size, size)))])
    (power,) = (one for one in directions(model) if one.name == "chips.power")
    assert not np.isfinite(Known(model, sums).course(power).value).any()


def test_what_a_change_explains_is_by_brute_force_the_misfit_that_it_takes(known):
    """All runs at once: parameters alike in all, the change of one shape, and another direction free in each run."""
    one, beside = (each for each in directions(known) if each.name in SD)
    paths, shape, dice = known.free(), np.array([0.0, 0.0, 0.5, 1.0]), np.random.default_rng(3)
    runs = dice.standard_normal((len(shape), 30, len(paths) + 1))
    told = Known(known, [cast(Moments, SimpleNamespace(weighted=rows.T @ rows)) for rows in runs])
    at = [paths.index(each.name) for each in (one, beside)]

    def left(*columns: np.ndarray) -> float:
        each = [np.kron(np.eye(len(shape))[i][:, None], rows[:, [at[1]]]) for i, rows in enumerate(runs)]
        wide = np.hstack([np.vstack(runs[:, :, :-1]), *each, *columns])
        prior, free = np.linalg.cholesky(told._precision).T, np.eye(len(shape)) / beside.sd
        parts = [np.pad(part, [(0, 0), (from_, wide.shape[1] - from_ - part.shape[1])]) for from_, part in
                 ((0, prior), (len(paths), free))]  # fmt: skip
        off = np.full(len(shape), (beside.usual - beside.now) / beside.sd)
        rows, y = np.vstack([wide, *parts]), np.concatenate([runs[:, :, -1].ravel(), -prior @ told._off, off])
        return float(((y - rows @ np.linalg.lstsq(rows, y)[0]) ** 2).sum())

    change = np.concatenate([size * rows[:, [at[0]]] for size, rows in zip(shape, runs, strict=True)])
    assert told.gain(one, shape, [beside]) == pytest.approx(left() - left(change), rel=1e-5)
