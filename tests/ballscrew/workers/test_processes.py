"""Recordings shared out among processes: the same numbers, errors that arrive, and processes that are lost."""

import os
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from ballscrew.workers.by_value import KEPT, MOST_LOST, dumps, loads
from ballscrew.workers.processes import WORTH_S, Home, Keepers, enough
from estimator.batch.trials import slow_trials_of
from estimator.effect import Effect, Param
from estimator.errors import EffectError, InputError
from estimator.hypotheses.moments import moments
from estimator.hypotheses.slopes import Column
from estimator.rig_folder.model_toml import own_effects
from estimator.terms import Heat
from estimator.work import Runs, Workers

OWN = '''
from estimator.effect import Effect, Param
from estimator.terms import SCREW, Heat

SHARE = 0.5


class Rubbing(Effect):
    """Something rubs.

    q = P / 2
    """

    power = Param(5.0, "W", lo=-50.0, hi=50.0, null=0.0, source="a guess")

    def terms(self, p, u, rig):
        yield Heat(SCREW, SHARE * p.power, over=rig.the_screw().overlap(50.0, 80.0))
'''


@pytest.fixture(scope="module")
def keepers() -> Iterator[Keepers]:
    with Home() as one, Home() as other:
        yield Keepers(map, [one, other])


@pytest.fixture
def rubbing(tmp_path) -> type[Effect]:
    (tmp_path / "effects.py").write_text(OWN)
    return own_effects(tmp_path / "effects.py")["Rubbing"]


def test_moments_with_an_effect_of_ones_own_are_the_same_to_the_bit(keepers, small, small_model, driven, live, rubbing):
    recordings = [
        live(small_model, small, driven(small, 900.0, (20, 500), omega), seed=n).recording
        for n, omega in enumerate((174.5, 90.0, 40.0))
    ]
    model = small_model + rubbing
    columns = [Column(model, path) for path in ("rubbing.power", "still_air.h", "nut_friction.power")]

    def asked(workers: Workers) -> list[np.ndarray]:
        trials = slow_trials_of(model, Runs(small, recordings, workers))
        return [m.weighted for _ in range(2) for m in moments(trials, model, columns)]

    alone, shared = asked(map), asked(keepers)
    assert len(alone) == 6
    np.testing.assert_array_equal(alone, shared)


def test_a_recording_stays_with_its_process_and_a_job_alone_travels(keepers):
    items = [np.full(3, float(n)) for n in range(4)]
    homes = [keepers.kept(lambda item: (os.getpid(), id(item)), items) for _ in range(2)]
    assert homes[0] == homes[1]
    assert homes[0][0][0] == homes[0][2][0] != homes[0][1][0]
    assert os.getpid() not in {pid for pid, _ in homes[0]}


def test_the_longest_is_by_itself_where_the_others_are_as_long_together(keepers):
    items = [np.full(n, 1.0) for n in (500, 3000, 700, 900)]
    first, longest, *others = keepers.kept(lambda item: os.getpid(), items)
    assert others == [first, first]
    assert longest != first


def test_no_more_is_kept_than_there_is_room_for():
    with Home() as home:
        items = [[n] for n in range(KEPT + 6)]
        assert [home.ask(dumps(len), item).result() for item in items] == [1] * len(items)
        assert len(home._kept) == KEPT
        assert home.ask(dumps(sum), items[0]).result() == 0  # sent once more


def test_errors_are_those_of_the_job(keepers):
    def job(item: int) -> int:
        raise EffectError("rubbing", f"model.toml: rubbing: {item}")

    with pytest.raises(EffectError, match=r"^model.toml: rubbing: 7$") as told:
        keepers.kept(job, [7])
    assert told.value.effect == "rubbing"


def test_a_process_that_is_lost_costs_its_job_once_more(tmp_path):
    mark = tmp_path / "lost"

    def job(item: str) -> str:
        if not Path(mark).exists():
            Path(mark).touch()
            os._exit(9)
        return item.upper()

    with Home() as home:
        first = home.ask(dumps(str.title), "kept before").result()
        assert (first, home.ask(dumps(job), "at work").result()) == ("Kept Before", "AT WORK")
        assert home.ask(dumps(job), "kept before").result() == "KEPT BEFORE"


def test_one_that_is_lost_again_and_again_is_one_line():
    with Home() as home, pytest.raises(InputError, match=rf"lost {MOST_LOST} times .*--workers 1$"):
        home.ask(dumps(lambda item: os._exit(9)), "x").result()


def test_who_leaves_while_it_works_waits_for_no_answer_and_it_does_not_begin_again(tmp_path):
    def job(folder: Path) -> None:
        (folder / str(os.getpid())).touch()
        time.sleep(20.0)

    with Home() as home:
        answer = home.ask(dumps(job), tmp_path)
        while not (begun := list(tmp_path.iterdir())):
            time.sleep(0.01)
    assert answer.done()
    assert isinstance(answer.exception(), InputError)
    assert list(tmp_path.iterdir()) == begun


def test_a_class_comes_back_as_itself_and_one_of_the_catalogue_by_its_name(rubbing, small_model):
    assert loads(dumps(rubbing)) is rubbing
    model = loads(dumps(small_model + rubbing))
    assert type(model.effects["rubbing"]) is rubbing
    assert [type(a) is type(b) for a, b in zip(model.effects.values(), small_model.effects.values(), strict=False)]

    class Here(Effect):
        """Made in a function.

        q = P
        """

        power = Param(1.0, "W", lo=0.0, hi=2.0, null=0.0, source="a guess")

        def terms(self, p, u, rig):
            yield Heat("screw", p.power)

    assert loads(dumps(Here)) is Here


def test_processes_are_started_where_that_pays():
    assert enough([600.0, 600.0]) == 1
    assert enough([WORTH_S]) == 1
    assert enough([WORTH_S, WORTH_S]) == min(os.cpu_count() or 1, 2)
