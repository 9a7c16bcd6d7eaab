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


def press_ctrl_c() -> None:
    os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_signal_sets_the_stop_token(number):
    with stop_on_signals() as stop:
        assert not stop.is_set()
        os.kill(os.getpid(), number)
        assert stop.is_set()
        assert signal.Signals(number).name in str(stop.reason())
        assert stop.reason().exit_code is ExitCode.ABORTED


def test_signal_interrupts_a_question():
    aborted = pytest.raises(AbortedError, match="SIGTERM")
    with stop_on_signals() as stop, aborted, stop.while_asking():
        os.kill(os.getpid(), signal.SIGTERM)


def test_repeated_ctrl_c_pauses_aborts_stops_and_is_then_ignored():
    with stop_on_signals(attended=True) as stop:
        stop(STARTED)
        assert stop.pause_requested() == ""
        press_ctrl_c()
        assert (stop.pause_requested(), stop.is_set()) == ("keyboard", False)
        press_ctrl_c()
        assert stop.is_set()
        assert isinstance(stop.reason(), InterruptedRunError)
        assert stop.reason().exit_code is ExitCode.INTERRUPTED
        with pytest.raises(StopNow):
            press_ctrl_c()
        press_ctrl_c()


def test_ctrl_c_aborts_an_unattended_run_at_once():
    with stop_on_signals() as stop:
        stop(STARTED)
        press_ctrl_c()
        assert stop.is_set()
        with pytest.raises(StopNow):
            press_ctrl_c()


def test_after_a_pause_ctrl_c_pauses_again():
    with stop_on_signals(attended=True) as stop:
        stop(STARTED)
        press_ctrl_c()
        stop.paused()
        stop.resumed()
        assert stop.pause_requested() == ""
        press_ctrl_c()
        assert (stop.pause_requested(), stop.is_set()) == ("keyboard", False)


def test_ctrl_c_in_a_question_pauses_and_while_paused_aborts():
    with stop_on_signals(attended=True) as stop:
        stop(STARTED)
        with pytest.raises(PauseRequestedError), stop.while_asking():
            press_ctrl_c()
        stop.paused()
        with pytest.raises(InterruptedRunError), stop.while_asking():
            press_ctrl_c()


def test_ctrl_c_outside_a_run_ends_the_program():
    with stop_on_signals(attended=True) as stop:
        with pytest.raises(KeyboardInterrupt):
            press_ctrl_c()
        assert not stop.is_set()


@pytest.mark.parametrize("attended", [True, False])
def test_two_ctrl_c_do_not_interrupt_sealing(capfd, attended):
    with stop_on_signals(attended=attended) as stop:
        stop(STARTED)
        stop(ENDED)
        press_ctrl_c()
        assert stop.is_set()  # so that the analysis ends
        assert stop.reason().exit_code is ExitCode.INTERRUPTED
        press_ctrl_c()
        with pytest.raises(KeyboardInterrupt):
            press_ctrl_c()
    lines = capfd.readouterr().err.split("\n\n")
    assert lines[0].strip() == "The run is over; its folder is being sealed. Please wait."
    assert lines[1].strip() == "Ctrl-C once more ends this now; 'rigrunner recover' seals the run."


def test_previous_handlers_are_restored():
    before = signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT)
    with stop_on_signals():
        assert signal.getsignal(signal.SIGTERM) != before[0]
    assert (signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT)) == before


def test_ctrl_c_is_ignored_while_the_rig_is_made_safe():
    with stop_on_signals() as stop:
        stop(STARTED)
        press_ctrl_c()
        stop.stop_interrupting()
        for _ in range(3):
            press_ctrl_c()
        stop(ENDED)
        press_ctrl_c()
