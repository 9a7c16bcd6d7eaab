"""Items in this process and in worker processes: one outcome each, even if a worker dies."""

from __future__ import annotations

import os
import signal
import threading
import time

import pytest

from rigrunner.jobs import InProcess, Processes, usable_cores
from unit.jobs.helpers_jobs import Squares, end_by, environment, hang

NEVER = threading.Event()


def outcomes_of(workers, task, items, stop=NEVER):
    """Return value or problem by item; each must come once, with its own place."""
    outcomes = list(workers.outcomes(task, items, stop))
    assert [items[outcome.place] for outcome in outcomes] == [outcome.item for outcome in outcomes]
    assert len({outcome.place for outcome in outcomes}) == len(outcomes)
    return {outcome.item: outcome.problem or outcome.answer.value for outcome in outcomes}


@pytest.mark.parametrize("workers", [InProcess(), Processes(1), Processes(3)])
def test_every_item_is_done_once_despite_failures(workers, tmp_path):
    task = Squares(tmp_path, refuses=(2,), breaks=(4,))
    assert outcomes_of(workers, task, [5, 4, 3, 2, 1]) == {
        5: 25,
        4: "ZeroDivisionError: 4",
        3: 9,
        2: "2 is refused (take another)",
        1: 1,
    }
    assert task.attempts() == [1, 2, 3, 4, 5]


@pytest.mark.parametrize("workers", [InProcess(), Processes(1)])
def test_only_bugs_have_a_traceback(workers, tmp_path):
    task = Squares(tmp_path, refuses=(2,), breaks=(1,))
    bug, error = workers.outcomes(task, [1, 2], NEVER)
    assert "in __call__" in bug.answer.trace
    assert error.answer.trace == ""


def test_item_that_kills_its_process_fails_alone(tmp_path):
    task = Squares(tmp_path, dies=(2,))
    answers = outcomes_of(Processes(2), task, [1, 2, 3, 4])
    assert answers.pop(2) == "the process was ended by SIGKILL, 2 times"
    assert answers == {1: 1, 3: 9, 4: 16}
    assert task.attempts() == [1, 2, 2, 3, 4]


@pytest.mark.skipif(not hasattr(signal, "SIGRTMIN"), reason="no real-time signals here")
def test_process_ended_by_a_real_time_signal_is_reported():
    number = signal.SIGRTMIN + 2
    answers = outcomes_of(Processes(1), end_by, [number])
    assert answers == {number: "the process was ended by SIGRTMIN+2, 2 times"}


def test_item_whose_process_died_once_is_repeated(tmp_path):
    task = Squares(tmp_path, dies_once=(2,))
    assert outcomes_of(Processes(1), task, [1, 2, 3]) == {1: 1, 2: 4, 3: 9}
    assert task.attempts() == [1, 2, 2, 3]


@pytest.mark.parametrize("workers", [InProcess(), Processes(2)])
def test_set_token_ends_the_outcomes(workers, tmp_path):
    stop, answers = threading.Event(), []
    for outcome in workers.outcomes(Squares(tmp_path), list(range(50)), stop):
        answers.append(outcome.item)
        stop.set()
    assert len(answers) in {1, 2}  # two processes may be ready at once


def test_stop_does_not_wait_for_running_items():
    stop = threading.Event()
    timer = threading.Timer(0.5, stop.set)
    timer.start()
    began = time.monotonic()
    assert not list(Processes(2).outcomes(hang, [60.0, 60.0], stop))
    assert time.monotonic() - began < 20


def test_worker_process_has_one_thread_for_linear_algebra(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    answers = outcomes_of(Processes(1), environment, ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"])
    assert answers == {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    assert os.environ["OMP_NUM_THREADS"] == "7"


def test_no_more_processes_than_items(tmp_path):
    task = Squares(tmp_path)
    outcomes_of(Processes(8), task, [1])
    assert len({mark.name.split("-")[1] for mark in tmp_path.iterdir()}) == 1


def test_no_items_give_no_outcomes(tmp_path):
    assert outcomes_of(Processes(2), Squares(tmp_path), []) == {}


def test_usable_cores_is_between_one_and_the_cpu_count():
    assert 1 <= usable_cores() <= (os.cpu_count() or 1)


def test_import_error_of_the_task_is_reported_for_every_item():
    class Local:
        def __reduce__(self):
            return __import__, ("no_such_module",)

    answers = outcomes_of(Processes(1), Local(), [1, 2])
    assert answers == dict.fromkeys([1, 2], "ModuleNotFoundError: No module named 'no_such_module'")


def test_workers_import_no_module_of_the_current_folder(monkeypatch, tmp_path):
    (tmp_path / "multiprocessing.py").write_text("open('was_imported', 'w')")
    monkeypatch.chdir(tmp_path)
    assert outcomes_of(Processes(1), Squares(tmp_path), [2]) == {2: 4}
    assert not (tmp_path / "was_imported").exists()
