"""Which signals are taken, and from which handlers; and a terminal that was closed."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import contextmanager

import pytest

from rigrunner.ending import ENDING, Consoles, signal_name, take_signals

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGUSR1"), reason="these are of POSIX")


def our_handler(_number, _frame):
    pass


def other_handler(_number, _frame):
    pass


@pytest.fixture
def restored():
    before = {number: signal.getsignal(number) for number in ENDING}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize(
    ("name", "present", "is_taken"),
    [
        ("SIGTERM", signal.SIG_DFL, True),
        ("SIGUSR1", signal.SIG_DFL, True),
        ("SIGTERM", other_handler, True),
        ("SIGHUP", other_handler, True),
        ("SIGUSR1", other_handler, False),  # such as a profiler
        ("SIGHUP", signal.SIG_IGN, False),  # nohup
        ("SIGTERM", signal.SIG_IGN, False),
    ],
)
@pytest.mark.usefixtures("restored")
def test_signal_is_taken_unless_another_handler_needs_it(name, present, is_taken):
    number = getattr(signal, name)
    signal.signal(number, present)
    assert take_signals([number], our_handler) == ({number: present} if is_taken else {})
    assert signal.getsignal(number) == (our_handler if is_taken else present)


@pytest.mark.skipif(sys.platform != "linux", reason="the table is that of Linux")
def test_every_signal_that_ends_a_program_is_known():
    """Those with the action Term in `man 7 signal`, except SIGKILL and those that Python ignores.

    SIGQUIT and SIGXCPU end a program too, and write a core.
    """
    names = (
        "SIGALRM SIGHUP SIGIO SIGPROF SIGPWR SIGQUIT SIGSTKFLT SIGTERM SIGUSR1 SIGUSR2 SIGVTALRM"
        " SIGXCPU"
    )
    numbered = {getattr(signal, name) for name in names.split() if hasattr(signal, name)}
    real_time = range(signal.SIGRTMIN, signal.SIGRTMAX + 1)
    assert sorted(ENDING) == sorted({*numbered, *real_time})


@pytest.mark.skipif(not hasattr(signal, "SIGRTMIN"), reason="there are no real-time signals")
def test_signal_has_the_name_of_the_manual():
    assert signal_name(signal.SIGTERM) == "SIGTERM"
    assert signal_name(signal.SIGRTMIN + 2) == "SIGRTMIN+2"


@contextmanager
def standard_output(descriptor):
    """Write the standard output there."""
    before = os.dup(1)
    os.dup2(descriptor, 1)
    try:
        yield
    finally:
        os.dup2(before, 1)
        os.close(before)


def test_only_a_closed_terminal_is_silenced():
    reader, terminal = os.openpty()
    os.set_blocking(reader, False)
    with standard_output(terminal):
        consoles = Consoles()
        consoles.silence_closed()
        os.write(1, b"still here")
        assert os.read(reader, 100) == b"still here"
        os.close(reader)
        with pytest.raises(OSError, match="Input/output error"):
            os.write(1, b"nobody")
        consoles.silence_closed()
        os.write(1, b"nobody")
    os.close(terminal)
