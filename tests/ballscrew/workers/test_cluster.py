"""Workers of a Dask scheduler: the numbers of one machine to the bit, also where a worker is killed at its work."""

import os
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from distributed import Client, LocalCluster, versions

from ballscrew.fleet.inspection import Inspection
from ballscrew.fleet.workers import LOST, shared
from ballscrew.workers import cluster
from ballscrew.workers.processes import working
from estimator.batch.trials import slow_trials_of
from estimator.errors import EffectError, InputError, SetupError
from estimator.hypotheses.moments import moments_of
from estimator.hypotheses.slopes import Column
from estimator.work import Runs, Workers
from tests.conftest import ROD, ballscrew, ended


@pytest.fixture(scope="module")
def dask() -> Iterator[LocalCluster]:
    """A scheduler, and two workers that are processes."""
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as started:
        yield started


@pytest.fixture(scope="module")
def rod(tmp_path_factory) -> Path:
    """A rig folder of two short recordings."""
    ignored = shutil.ignore_patterns("steps.csv", "pulses.csv")
    return shutil.copytree(ROD, tmp_path_factory.mktemp("plant") / "rod", ignore=ignored)


def test_a_worker_that_is_killed_at_its_work_changes_no_bit(dask, small, small_model, driven, live, tmp_path):
    recordings = [live(small_model, small, driven(small, 900.0, (20, 500), w), seed=1).recording for w in (170.0, 90.0)]
    columns, mark = [Column(small_model, path) for path in ("still_air.h", "nut_friction.power")], tmp_path / "killed"

    def asked(workers: Workers, kills: bool) -> list[np.ndarray]:
        def sums(trial):
            if kills and not mark.exists():
                mark.touch()
                os.kill(os.getpid(), signal.SIGKILL)
            return moments_of(trial, small_model, columns).weighted

        return slow_trials_of(small_model, Runs(small, recordings, workers)).each(sums)

    with working(dask.scheduler_address) as workers:
        found = asked(workers, kills=True)
    assert mark.exists()
    np.testing.assert_array_equal(found, asked(map, kills=False))


def test_every_rig_is_looked_at_though_a_worker_is_killed(dask, tmp_path):
    def looked(folder: Path) -> Inspection:
        if folder.name == "bad" and not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return Inspection(str(folder))

    folders, mark = [tmp_path / name for name in ("a", "bad", "c")], tmp_path / "killed"
    for folder in folders:
        folder.mkdir()
    found = list(shared(looked, folders, dask.scheduler_address))
    assert mark.exists()
    assert sorted(one.folder for one in found) == [str(folder) for folder in folders]
    assert not any(one.error for one in found)


@pytest.mark.parametrize("command", ["fleet", "review", "suggest"])
def test_a_command_says_the_same(dask, rod, command):
    alone, there = (
        [line for line in ballscrew(command, rod, "--json", "--workers", by)[1].splitlines() if "seconds" not in line]
        for by in (1, dask.scheduler_address)
    )
    assert len(alone) > 10
    assert there == alone


def test_errors_are_those_of_the_job_and_of_what_is_not_there(dask, tmp_path):
    def fails(item: int) -> int:
        raise EffectError("rubbing", f"model.toml: rubbing: {item}")

    with working(dask.scheduler_address) as workers, pytest.raises(EffectError, match=r"^model.toml: rubbing: 7$"):
        workers.kept(fails, [7])
    (found,) = shared(Inspection, [tmp_path / "none"], dask.scheduler_address)
    assert found.error.endswith(f"sees no folder {tmp_path / 'none'}: share it under the same path")


def test_one_that_is_lost_again_and_again_is_told(dask, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "MOST_LOST", 1)
    monkeypatch.setattr(dask.scheduler, "allowed_failures", 0)

    def dies(item: object) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    with working(dask.scheduler_address) as workers, pytest.raises(InputError, match=r"lost 1 times at one job"):
        workers.kept(dies, ["x"])
    (found,) = shared(dies, [tmp_path], dask.scheduler_address)
    assert found.error == LOST


def said(address: str) -> str:
    _, err = ended(2, "review", ROD / "check.csv", "--workers", address)
    return err.splitlines()[-1]


def test_what_will_not_do_is_one_line(dask, monkeypatch):
    monkeypatch.setattr(cluster, "ANSWER_S", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        for port in (1, silent.getsockname()[1]):
            address = f"tcp://127.0.0.1:{port}"
            assert said(address).startswith(f"error: --workers {address}: no Dask scheduler answers there within 0.2 s")
    assert "neither a number of processes nor tcp://HOST:PORT" in said("tcp:plant")
    monkeypatch.setattr(cluster, "ANSWER_S", 10.0)
    there = versions._version_cached
    monkeypatch.setattr(versions, "_version_cached", lambda name: "9.9" if name == "numpy" else there(name))
    assert said(dask.scheduler_address).endswith(f"numpy is {np.__version__} there, 9.9 here; install the same")


def test_a_scheduler_without_workers_is_told_and_one_that_is_lost(monkeypatch):
    monkeypatch.setattr(cluster, "STILL_THERE_S", 0.2)
    monkeypatch.setattr(cluster, "ANSWER_S", 1.0)
    with LocalCluster(n_workers=0, dashboard_address=":0", silence_logs=50) as empty:
        assert "the scheduler has no worker; start one, `dask worker tcp://" in said(empty.scheduler_address)
        with (
            Client(empty, set_as_default=False) as client,
            pytest.raises(InputError, match=r"lost, or its last worker"),
        ):
            cluster.Cluster(map, client).kept(len, ["x"])
    with pytest.raises(InputError, match=r"^the scheduler is lost, or its last worker"):  # for long: Dask closed it
        cluster.Cluster(map, client).kept(len, ["x"])


def test_without_the_extra_its_name_is_told(monkeypatch):
    monkeypatch.delitem(sys.modules, "ballscrew.workers.cluster")
    monkeypatch.delattr("ballscrew.workers.cluster")
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        pytest.raises(SetupError, match=r"no distributed here; `pip install 'ballscrew\[cluster\]'`"),
        working("tcp://x:1"),
    ):
        pass


def test_nothing_of_it_is_imported_where_it_is_not_asked_for():
    commands = ", ".join(f"ballscrew.commands.{name}" for name in ("fleet", "improve", "review"))
    program = f"import sys, {commands}; print({{'dask', 'distributed'}} & {{*sys.modules}})"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
