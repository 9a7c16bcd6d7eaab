"""The progress lines of a batch, and how signals stop it."""

from __future__ import annotations

import os
import signal

import pytest

from rigrunner.api.errors import AbortedError, ExitCode
from rigrunner.cli.batch import CountedLines
from rigrunner.cli.stopping import batch_stop_on_signals


def printed_lines(capsys, calls, total=100):
    clock = iter([0.0, *(10.0 * n for n in range(1, 200))])
    progress = CountedLines("runs", lambda: next(clock))
    for done in calls:
        progress(done, total)
    return capsys.readouterr().err.splitlines()


def test_progress_is_printed_at_intervals_with_the_time_left(capsys):
    printed = printed_lines(capsys, range(101))
    assert len(printed) == 20
    assert printed[0] == "5 of 100 runs, 3 min 10 s left"  # one line's time has passed: 2 s a run
    assert printed[-1] == "100 of 100 runs"


def test_runs_done_before_do_not_count_for_the_pace(capsys):
    printed = printed_lines(capsys, [90, 91, 92, 95])
    assert printed == ["90 of 100 runs were done before", "95 of 100 runs, 10 s left"]


def send_signals(*numbers):
    """Send these signals to a batch, which ends with an error of its own if it can."""
    with batch_stop_on_signals() as stop:
        for number in numbers:
            os.kill(os.getpid(), number)
            assert stop.is_set()
        raise AbortedError("stopped after 3", hint="go on")


def test_first_ctrl_c_stops_the_batch_and_keeps_its_hint():
    with pytest.raises(AbortedError, match="from the keyboard: stopped after 3") as caught:
        send_signals(signal.SIGINT)
    assert (caught.value.exit_code, caught.value.hint) == (ExitCode.INTERRUPTED, "go on")


def test_second_ctrl_c_ends_the_batch_at_once():
    with pytest.raises(KeyboardInterrupt):
        send_signals(signal.SIGINT, signal.SIGINT)


def test_sigterm_stops_the_batch_with_its_own_exit_code():
    with pytest.raises(AbortedError, match="SIGTERM: stopped") as caught:
        send_signals(signal.SIGTERM)
    assert caught.value.exit_code is ExitCode.ABORTED
