"""Items done here, in processes and on a cluster: the same outcomes, each once, whoever dies."""

from __future__ import annotations

import os
import signal
import threading
import time

import pytest

from rigrunner.jobs import InProcess, Processes, usable_cores
from unit.jobs.helpers_jobs import Squares, end_by, environment, hang

NEVER = threading.Event()


def done(workers, task, items, stop=NEVER):
    """Return value or problem by item, and that each came once at its own place."""
    outcomes = list(workers.outcomes(task, items, stop))
    assert [items[outcome.place] for outcome in outcomes] == [outcome.item for outcome in outcomes]
    assert len({outcome.place for outcome in outcomes}) == len(outcomes)
    return {outcome.item: outcome.problem or outcome.answer.value for outcome in outcomes}


@pytest.mark.parametrize("workers", [InProcess(), Processes(1), Processes(3)])
def test_every_item_is_done_once_and_what_fails_ends_nothing(workers, tmp_path):
    task = Squares(tmp_path, refuses=(2,), breaks=(4,))
    assert done(workers, task, [5, 4, 3, 2, 1]) == {
        5: 25,
        4: "ZeroDivisionError: 4",
        3: 9,
        2: "2 is refused (take another)",
        1: 1,
    }
    assert task.attempts() == [1, 2, 3, 4, 5]


@pytest.mark.parametrize("workers", [InProcess(), Processes(1)])
def test_a_bug_keeps_its_traceback_and_an_error_has_none(workers, tmp_path):
    task = Squares(tmp_path, refuses=(2,), breaks=(1,))
    bug, error = workers.outcomes(task, [1, 2], NEVER)
    assert "in __call__" in bug.answer.trace
    assert error.answer.trace == ""


def test_what_kills_its_process_is_a_failure_of_its_own(tmp_path):
    task = Squares(tmp_path, dies=(2,))
    answers = done(Processes(2), task, [1, 2, 3, 4])
    assert answers.pop(2) == "the process was ended by SIGKILL, 2 times"
    assert answers == {1: 1, 3: 9, 4: 16}
    assert task.attempts() == [1, 2, 2, 3, 4]


@pytest.mark.skipif(not hasattr(signal, "SIGRTMIN"), reason="no real-time signals here")
def test_a_process_that_a_real_time_signal_ended_is_reported():
    number = signal.SIGRTMIN + 2
    answers = done(Processes(1), end_by, [number])
    assert answers == {number: "the process was ended by SIGRTMIN+2, 2 times"}


def test_what_was_only_in_the_way_is_done_again(tmp_path):
    task = Squares(tmp_path, dies_once=(2,))
    assert done(Processes(1), task, [1, 2, 3]) == {1: 1, 2: 4, 3: 9}
    assert task.attempts() == [1, 2, 2, 3]


@pytest.mark.parametrize("workers", [InProcess(), Processes(2)])
def test_nothing_more_comes_once_the_token_is_set(workers, tmp_path):
    stop, answers = threading.Event(), []
    for outcome in workers.outcomes(Squares(tmp_path), list(range(50)), stop):
        answers.append(outcome.item)
        stop.set()
    assert len(answers) in {1, 2}  # two processes may be ready at once


def test_a_stop_does_not_wait_for_what_is_under_way():
    stop = threading.Event()
    timer = threading.Timer(0.5, stop.set)
    timer.start()
    began = time.monotonic()
    assert not list(Processes(2).outcomes(hang, [60.0, 60.0], stop))
    assert time.monotonic() - began < 20


def test_each_process_has_one_thread_for_linear_algebra(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    answers = done(Processes(1), environment, ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"])
    assert answers == {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    assert os.environ["OMP_NUM_THREADS"] == "7"


def test_no_more_processes_than_items(tmp_path):
    task = Squares(tmp_path)
    done(Processes(8), task, [1])
    assert len({mark.name.split("-")[1] for mark in tmp_path.iterdir()}) == 1


def test_of_nothing_comes_nothing(tmp_path):
    assert done(Processes(2), Squares(tmp_path), []) == {}


def test_cores_that_may_be_used():
    assert 1 <= usable_cores() <= (os.cpu_count() or 1)


def test_a_task_that_cannot_be_imported_is_told_of_every_item():
    class Local:
        def __reduce__(self):
            return __import__, ("no_such_module",)

    answers = done(Processes(1), Local(), [1, 2])
    assert answers == dict.fromkeys([1, 2], "ModuleNotFoundError: No module named 'no_such_module'")


def test_processes_import_no_module_of_the_folder_that_one_stands_in(monkeypatch, tmp_path):
    (tmp_path / "multiprocessing.py").write_text("open('was_imported', 'w')")
    monkeypatch.chdir(tmp_path)
    assert done(Processes(1), Squares(tmp_path), [2]) == {2: 4}
    assert not (tmp_path / "was_imported").exists()
