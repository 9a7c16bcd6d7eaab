"""Items on a local Dask cluster of several processes."""

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
def cluster():
    with two_workers() as cluster:
        yield cluster


def test_every_item_is_done_once_despite_failures(cluster, tmp_path):
    task = Squares(tmp_path, refuses=(2,), breaks=(4,))
    outcomes = list(Cluster(cluster.scheduler_address).outcomes(task, range(6), NEVER))
    answers = {outcome.item: outcome.problem or outcome.answer.value for outcome in outcomes}
    assert answers == {
        0: 0, 1: 1, 2: "2 is refused (take another)", 3: 9, 4: "ZeroDivisionError: 4", 5: 25,
    }  # fmt: skip
    assert task.attempts() == [0, 1, 2, 3, 4, 5]


def test_each_item_is_returned_once_after_a_worker_is_killed(cluster, tmp_path):
    task = Squares(tmp_path, dies_once=(3,))
    outcomes = list(Cluster(cluster.scheduler_address).outcomes(task, range(8), NEVER))
    assert sorted(outcome.answer.value for outcome in outcomes) == [n**2 for n in range(8)]
    repeated = Counter(task.attempts()) - Counter(range(8))
    assert repeated[3] == 1  # others only if their values were not fetched yet from the dead worker
    assert set(repeated.values()) == {1}


@pytest.mark.thorough
def test_item_that_kills_every_worker_fails_alone(tmp_path):
    task = Squares(tmp_path, dies=(1,))
    with two_workers() as cluster:  # its own: Dask may not restart all that die
        outcomes = list(Cluster(cluster.scheduler_address).outcomes(task, range(4), NEVER))
    answers = {outcome.item: outcome.problem or outcome.answer.value for outcome in outcomes}
    assert answers == {0: 0, 1: "each worker of the cluster that began it died", 2: 4, 3: 9}


@pytest.mark.thorough
def test_items_beside_a_killed_worker_still_succeed(tmp_path):
    """With so many deaths, the scheduler alone would give up every queued item."""
    task = Squares(tmp_path, dies=(1, 2))
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}), two_workers() as strict:
        outcomes = list(Cluster(strict.scheduler_address).outcomes(task, range(12), NEVER))
    failed = sorted(outcome.item for outcome in outcomes if outcome.problem)
    assert failed == [1, 2]
    assert sorted(outcome.answer.value for outcome in outcomes if not outcome.problem) == [
        n**2 for n in range(12) if n not in failed
    ]


def test_set_token_ends_the_outcomes(cluster, tmp_path):
    cluster.wait_for_workers(1, timeout=60)  # the test before this one killed some
    stop, outcomes = threading.Event(), []
    for outcome in Cluster(cluster.scheduler_address).outcomes(Squares(tmp_path), range(50), stop):
        outcomes.append(outcome)
        stop.set()
    assert len(outcomes) == 1


def test_missing_scheduler_is_a_usage_error():
    with pytest.raises(UsageError, match=r"no Dask scheduler answers at 'tcp://127.0.0.1:1'"):
        list(Cluster("tcp://127.0.0.1:1", patience_s=1).outcomes(abs, [1], NEVER))


@pytest.mark.parametrize("address", ["nonsense", "udp://x", "127.0.0.1:port", ""])
def test_invalid_address_is_a_usage_error(address):
    with pytest.raises(UsageError, match="no Dask scheduler"):
        list(Cluster(address, patience_s=1).outcomes(abs, [1], NEVER))


def test_program_ends_quietly_after_a_wrong_address():
    program = (
        "import threading\nfrom rigrunner.jobs import Cluster\n"
        "try: list(Cluster('nonsense', 1).outcomes(abs, [1], threading.Event()))\n"
        "except Exception as error: print(error)"
    )
    began = time.monotonic()
    result = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert result.stdout.startswith("no Dask scheduler answers at 'nonsense'")
    assert result.stderr == ""
    assert time.monotonic() - began < 20


def test_cluster_without_workers_is_a_usage_error():
    with two_workers(0) as empty, pytest.raises(UsageError, match="has no worker"):
        list(Cluster(empty.scheduler_address).outcomes(abs, [1], NEVER))


def test_missing_dask_is_reported(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(MissingPackageError, match=r"rigrunner\[dask\]"):
        list(Cluster("tcp://127.0.0.1:1").outcomes(abs, [1], NEVER))


@pytest.mark.thorough
def test_lost_scheduler_is_a_data_error(tmp_path):
    with two_workers(1) as cluster:
        outcomes = Cluster(cluster.scheduler_address).outcomes(Squares(tmp_path), range(500), NEVER)
        next(outcomes)
        cluster.close()
        with pytest.raises(DataError, match="scheduler of the cluster is gone"):
            list(outcomes)
