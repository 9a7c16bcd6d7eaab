"""Items on a Dask cluster of several processes on this machine, one of which is killed."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections import Counter

import pytest

from rigrunner.api.errors import DataError, MissingPackageError, UsageError
from rigrunner.jobs import Cluster
from unit.jobs.helpers_cluster import two_workers
from unit.jobs.helpers_jobs import Squares

dask = pytest.importorskip("dask")
pytest.importorskip("distributed")
NEVER = threading.Event()


@pytest.fixture(scope="module")
def two():
    with two_workers() as cluster:
        yield cluster


def test_every_item_is_done_once_and_what_fails_ends_nothing(two, tmp_path):
    task = Squares(tmp_path, refuses=(2,), breaks=(4,))
    outcomes = list(Cluster(two.scheduler_address).outcomes(task, range(6), NEVER))
    answers = {done.item: done.problem or done.answer.value for done in outcomes}
    assert answers == {
        0: 0, 1: 1, 2: "2 is refused (take another)", 3: 9, 4: "ZeroDivisionError: 4", 5: 25,
    }  # fmt: skip
    assert task.attempts() == [0, 1, 2, 3, 4, 5]


def test_each_item_comes_once_though_a_worker_is_killed(two, tmp_path):
    task = Squares(tmp_path, dies_once=(3,))
    outcomes = list(Cluster(two.scheduler_address).outcomes(task, range(8), NEVER))
    assert sorted(done.answer.value for done in outcomes) == [n**2 for n in range(8)]
    again = Counter(task.attempts()) - Counter(range(8))
    assert again[3] == 1  # others only if their values were not fetched yet from the dead worker
    assert set(again.values()) == {1}


@pytest.mark.thorough
def test_what_kills_every_worker_is_a_failure_of_its_own(two, tmp_path):
    task = Squares(tmp_path, dies=(1,))
    outcomes = list(Cluster(two.scheduler_address).outcomes(task, range(4), NEVER))
    answers = {done.item: done.problem or done.answer.value for done in outcomes}
    assert answers == {0: 0, 1: "each worker of the cluster that began it died", 2: 4, 3: 9}


@pytest.mark.thorough
def test_who_only_worked_beside_it_is_not_blamed(tmp_path):
    """Deaths enough for every item of the queue to be given up by the scheduler."""
    task = Squares(tmp_path, dies=(1, 2))
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}), two_workers() as strict:
        outcomes = list(Cluster(strict.scheduler_address).outcomes(task, range(12), NEVER))
    failed = sorted(done.item for done in outcomes if done.problem)
    assert failed == [1, 2]
    assert sorted(done.answer.value for done in outcomes if not done.problem) == [
        n**2 for n in range(12) if n not in failed
    ]


def test_nothing_more_comes_once_the_token_is_set(two, tmp_path):
    two.wait_for_workers(1, timeout=60)  # the test before this one killed some
    stop, outcomes = threading.Event(), []
    for done in Cluster(two.scheduler_address).outcomes(Squares(tmp_path), range(50), stop):
        outcomes.append(done)
        stop.set()
    assert len(outcomes) == 1


def test_where_no_scheduler_is():
    with pytest.raises(UsageError, match=r"no Dask scheduler answers at 'tcp://127.0.0.1:1'"):
        list(Cluster("tcp://127.0.0.1:1", patience_s=1).outcomes(abs, [1], NEVER))


@pytest.mark.parametrize("address", ["nonsense", "udp://x", "127.0.0.1:port", ""])
def test_an_address_that_is_none(address):
    with pytest.raises(UsageError, match="no Dask scheduler"):
        list(Cluster(address, patience_s=1).outcomes(abs, [1], NEVER))


def test_a_program_that_asked_at_a_wrong_address_ends_in_silence():
    program = (
        "import threading\nfrom rigrunner.jobs import Cluster\n"
        "try: list(Cluster('nonsense', 1).outcomes(abs, [1], threading.Event()))\n"
        "except Exception as error: print(error)"
    )
    began = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("no Dask scheduler answers at 'nonsense'")
    assert done.stderr == ""
    assert time.monotonic() - began < 20


def test_a_cluster_without_workers():
    with two_workers(0) as none, pytest.raises(UsageError, match="has no worker"):
        list(Cluster(none.scheduler_address).outcomes(abs, [1], NEVER))


def test_without_the_package(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(MissingPackageError, match=r"rigrunner\[dask\]"):
        list(Cluster("tcp://127.0.0.1:1").outcomes(abs, [1], NEVER))


@pytest.mark.thorough
def test_a_scheduler_that_is_lost(tmp_path):
    with two_workers(1) as cluster:
        outcomes = Cluster(cluster.scheduler_address).outcomes(Squares(tmp_path), range(500), NEVER)
        next(outcomes)
        cluster.close()
        with pytest.raises(DataError, match="scheduler of the cluster is gone"):
            list(outcomes)
