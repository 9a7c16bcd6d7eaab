"""Which signals are taken, and from which handlers."""

from __future__ import annotations

import signal

import pytest

from rigrunner.ending import ENDING, take_signals

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
