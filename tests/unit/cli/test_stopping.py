from __future__ import annotations

import os
import signal

import pytest

from rigrunner.api.errors import AbortedError
from rigrunner.cli.stopping import stop_on_signals


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_sets_the_token_and_leaves_the_program_running(number):
    with stop_on_signals() as stop:
        assert not stop.is_set()
        os.kill(os.getpid(), number)
        assert stop.is_set()


def test_a_signal_breaks_off_a_question():
    aborted = pytest.raises(AbortedError, match="SIGTERM")
    with stop_on_signals() as stop, aborted, stop.while_asking():
        os.kill(os.getpid(), signal.SIGTERM)


def test_the_former_handlers_return():
    before = signal.getsignal(signal.SIGTERM)
    with stop_on_signals():
        assert signal.getsignal(signal.SIGTERM) != before
    assert signal.getsignal(signal.SIGTERM) == before
