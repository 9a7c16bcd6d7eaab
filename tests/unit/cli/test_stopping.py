from __future__ import annotations

import os
import signal

import pytest

from rigrunner.api.errors import AbortedError, ExitCode
from rigrunner.api.events import Outcome, RunEnded, RunStarted
from rigrunner.cli.stopping import InterruptedRunError, stop_on_signals
from rigrunner.engine.pausing import PauseRequestedError, StopNow

STAMP = {"seq": 0, "monotonic_s": 0.0, "utc": ""}
STARTED = RunStarted(**STAMP, run_id="r", steps=1, estimated_s=1.0)
ENDED = RunEnded(**STAMP, outcome=Outcome.COMPLETED)


def press() -> None:
    os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_sets_the_token_and_leaves_the_program_running(number):
    with stop_on_signals() as stop:
        assert not stop.is_set()
        os.kill(os.getpid(), number)
        assert stop.is_set()
        assert signal.Signals(number).name in str(stop.reason())
        assert stop.reason().exit_code is ExitCode.ABORTED


def test_a_signal_breaks_off_a_question():
    aborted = pytest.raises(AbortedError, match="SIGTERM")
    with stop_on_signals() as stop, aborted, stop.while_asking():
        os.kill(os.getpid(), signal.SIGTERM)


def test_ctrl_c_pauses_then_aborts_then_stops_now_and_then_waits():
    with stop_on_signals(attended=True) as stop:
        stop(STARTED)
        assert stop.pause_requested() == ""
        press()
        assert (stop.pause_requested(), stop.is_set()) == ("keyboard", False)
        press()
        assert stop.is_set()
        assert isinstance(stop.reason(), InterruptedRunError)
        assert stop.reason().exit_code is ExitCode.INTERRUPTED
        with pytest.raises(StopNow):
            press()
        press()


def test_where_nobody_is_there_ctrl_c_aborts_at_once():
    with stop_on_signals() as stop:
        stop(STARTED)
        press()
        assert stop.is_set()
        with pytest.raises(StopNow):
            press()


def test_after_a_pause_ctrl_c_pauses_again():
    with stop_on_signals(attended=True) as stop:
        stop(STARTED)
        press()
        stop.paused()
        stop.resumed()
        assert stop.pause_requested() == ""
        press()
        assert (stop.pause_requested(), stop.is_set()) == ("keyboard", False)


def test_ctrl_c_breaks_off_a_question_to_pause_and_while_paused_to_abort():
    with stop_on_signals(attended=True) as stop:
        stop(STARTED)
        with pytest.raises(PauseRequestedError), stop.while_asking():
            press()
        stop.paused()
        with pytest.raises(InterruptedRunError), stop.while_asking():
            press()


def test_outside_of_a_run_ctrl_c_ends_the_program():
    with stop_on_signals(attended=True) as stop:
        with pytest.raises(KeyboardInterrupt):
            press()
        assert not stop.is_set()


@pytest.mark.parametrize("attended", [True, False])
def test_until_a_run_is_sealed_two_ctrl_c_break_nothing_off(capfd, attended):
    with stop_on_signals(attended=attended) as stop:
        stop(STARTED)
        stop(ENDED)
        press()
        assert stop.is_set()  # which ends its analysis
        assert stop.reason().exit_code is ExitCode.INTERRUPTED
        press()
        with pytest.raises(KeyboardInterrupt):
            press()
    lines = capfd.readouterr().err.split("\n\n")
    assert lines[0].strip() == "The run is over; its folder is being sealed. Please wait."
    assert lines[1].strip() == "Ctrl-C once more ends this now; 'rigrunner recover' seals the run."


def test_the_former_handlers_return():
    before = signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT)
    with stop_on_signals():
        assert signal.getsignal(signal.SIGTERM) != before[0]
    assert (signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT)) == before


def test_while_the_rig_is_made_safe_no_ctrl_c_breaks_that_off():
    with stop_on_signals() as stop:
        stop(STARTED)
        press()
        stop.stop_interrupting()
        for _ in range(3):
            press()
        stop(ENDED)
        press()
