"""How far a batch is, as lines, and by whom it is done."""

from __future__ import annotations

import os
import signal

import pytest

from rigrunner.api.errors import AbortedError, ExitCode
from rigrunner.cli.batch import CountedLines
from rigrunner.cli.stopping import batch_stop_on_signals


def lines(capsys, calls, of=100):
    clock = iter([0.0, *(10.0 * n for n in range(1, 200))])
    progress = CountedLines("runs", lambda: next(clock))
    for done in calls:
        progress(done, of)
    return capsys.readouterr().err.splitlines()


def test_a_line_now_and_then_with_the_time_left(capsys):
    printed = lines(capsys, range(101))
    assert len(printed) == 20
    assert printed[0] == "5 of 100 runs, 3 min 10 s left"  # one line's time has passed: 2 s a run
    assert printed[-1] == "100 of 100 runs"


def test_what_was_done_before_does_not_count_for_the_pace(capsys):
    printed = lines(capsys, [90, 91, 92, 95])
    assert printed == ["90 of 100 runs were done before", "95 of 100 runs, 10 s left"]


def signalled(*numbers):
    """Run a batch that is signalled, and ends by an error of its own where it can."""
    with batch_stop_on_signals() as stop:
        for number in numbers:
            os.kill(os.getpid(), number)
            assert stop.is_set()
        raise AbortedError("stopped after 3", hint="go on")


def test_the_first_ctrl_c_stops_the_batch_and_says_how_to_go_on():
    with pytest.raises(AbortedError, match="from the keyboard: stopped after 3") as ended:
        signalled(signal.SIGINT)
    assert (ended.value.exit_code, ended.value.hint) == (ExitCode.INTERRUPTED, "go on")


def test_the_second_one_ends_it_at_once():
    with pytest.raises(KeyboardInterrupt):
        signalled(signal.SIGINT, signal.SIGINT)


def test_a_signal_stops_it_with_its_own_code():
    with pytest.raises(AbortedError, match="SIGTERM: stopped") as ended:
        signalled(signal.SIGTERM)
    assert ended.value.exit_code is ExitCode.ABORTED
