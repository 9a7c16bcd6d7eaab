"""Which signals are taken, and from whom."""

from __future__ import annotations

import signal

import pytest

from rigrunner.ending import ENDING, take_signals

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGUSR1"), reason="these are of POSIX")


def ours(_number, _frame):
    pass


def of_another(_number, _frame):
    pass


@pytest.fixture
def restored():
    before = {each: signal.getsignal(each) for each in ENDING}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize(
    ("name", "present", "is_taken"),
    [
        ("SIGTERM", signal.SIG_DFL, True),
        ("SIGUSR1", signal.SIG_DFL, True),
        ("SIGTERM", of_another, True),
        ("SIGHUP", of_another, True),
        ("SIGUSR1", of_another, False),  # such as a profiler
        ("SIGHUP", signal.SIG_IGN, False),  # nohup
        ("SIGTERM", signal.SIG_IGN, False),
    ],
)
@pytest.mark.usefixtures("restored")
def test_a_signal_is_taken_where_nobody_else_wants_it(name, present, is_taken):
    number = getattr(signal, name)
    signal.signal(number, present)
    assert take_signals([number], ours) == ({number: present} if is_taken else {})
    assert signal.getsignal(number) == (ours if is_taken else present)
