from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from rigrunner.api import calling
from rigrunner.api.calling import InlineCaller, ThreadCaller
from rigrunner.api.errors import DeviceLostError, DeviceTimeoutError


@pytest.fixture(params=[None, 0.02], ids=["one wait", "in slices, as on Windows"])
def caller(request):
    caller = ThreadCaller("tester")
    caller.grace_s = 0.05
    caller._slice_s = request.param
    yield caller
    caller.stop()


def test_all_calls_run_in_one_other_thread(caller):
    names = {caller.call("ask", lambda: threading.current_thread().name, 5) for _ in range(5)}
    assert names == {"device tester"}


def test_stop_ends_the_thread_and_the_next_call_starts_another(caller):
    first = caller.call("ask", threading.current_thread, 5)
    caller.stop()
    first.join(10)
    assert not first.is_alive()
    assert caller.call("ask", threading.current_thread, 5) is not first


def test_result_and_error_are_returned_to_the_caller(caller):
    def refuse() -> None:
        raise TimeoutError("the instrument's own")

    assert caller.call("ask", lambda: 42, 5) == 42
    with pytest.raises(TimeoutError, match="the instrument's own"):
        caller.call("ask", refuse, 5)
    assert caller.call("ask", lambda: 43, 5) == 43


def test_hanging_call_times_out_and_the_device_counts_as_lost(caller):
    release = threading.Event()
    before = time.monotonic()
    with pytest.raises(DeviceTimeoutError, match=r"'read' did not return within 0\.05 s$"):
        caller.call("read", release.wait, 0.05)
    assert time.monotonic() - before < 10.0
    with pytest.raises(DeviceLostError, match="cannot set: an earlier call, 'read', still hangs"):
        caller.call("set", lambda: None, 5)
    release.set()


def test_time_out_that_ends_in_time_is_the_fault_of_the_device(caller, monkeypatch):
    monkeypatch.setattr(calling, "_LATE_S", 60.0)
    release = threading.Event()
    with pytest.raises(DeviceTimeoutError) as caught:
        caller.call("read", release.wait, 1.0)
    release.set()
    assert not caught.value.hint


_STOPPED_PROGRAM = """
import os, signal, subprocess, sys, threading
from rigrunner.api.calling import ThreadCaller
from rigrunner.api.errors import DeviceTimeoutError

def read():
    resume = f"import os, signal, time; time.sleep(4); os.kill({os.getpid()}, signal.SIGCONT)"
    subprocess.Popen([sys.executable, "-c", resume])
    os.kill(os.getpid(), signal.SIGSTOP)
    threading.Event().wait()

try:
    ThreadCaller("tester").call("read", read, 0.5)
except DeviceTimeoutError as error:
    print(error.message, error.hint, sep=chr(10))
"""


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="signals of Unix")
def test_time_out_of_a_suspended_program_says_so():
    result = subprocess.run(
        [sys.executable, "-c", _STOPPED_PROGRAM], check=True, capture_output=True, text=True
    )
    message, hint = result.stdout.splitlines()
    assert message == "'read' did not return within 0.5 s"
    assert hint.startswith("the device may have answered: this program itself was stopped")
    assert float(hint.split()[-2]) > 2.0


def test_urgent_call_runs_while_another_hangs(caller):
    release = threading.Event()
    with pytest.raises(DeviceTimeoutError):
        caller.call("read", release.wait, 0.05)
    assert caller.call_urgently("make safe", lambda: "safe", 5) == "safe"
    assert caller.call_urgently("close", lambda: "closed", 5) == "closed"
    release.set()


def test_urgent_call_waits_for_a_call_that_ends_in_time(caller):
    caller.grace_s = 5.0
    began, order = threading.Event(), []

    def slow() -> None:
        began.set()
        time.sleep(0.05)
        order.append("slow")

    interrupted = threading.Thread(target=caller.call, args=("set", slow, 5))
    interrupted.start()
    assert began.wait(5)
    caller.call_urgently("make safe", lambda: order.append("safe"), 5)
    interrupted.join()
    assert order == ["slow", "safe"]


def test_call_interrupted_before_it_began_never_runs(caller, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    release, calls = threading.Event(), []
    caller.start("read", release.wait)
    with monkeypatch.context() as patched:
        patched.setattr(calling, "_is_over", interrupt)
        with pytest.raises(KeyboardInterrupt):
            caller.call("set", lambda: calls.append("set"), 5)
    release.set()
    assert caller.call("ask", lambda: "after it", 5) == "after it"
    assert calls == []


def test_timed_out_call_that_never_began_is_not_run_later(caller):
    release, calls = threading.Event(), []
    with pytest.raises(DeviceTimeoutError):
        caller.call("read", release.wait, 0.02)
    with pytest.raises(DeviceTimeoutError):
        caller._run("set", lambda: calls.append("set"), 0.02)
    release.set()
    caller.call_urgently("close", lambda: None, 5)
    time.sleep(0.05)
    assert calls == []


def test_no_wait_is_longer_than_a_slice(caller, monkeypatch):
    """Signals are handled between two slices, even if they do not interrupt a wait."""
    waits = []

    def recorded_wait(call, within_s=0.0):
        waits.append(within_s)
        return is_over(call, within_s)

    is_over = calling._is_over
    monkeypatch.setattr(calling, "_is_over", recorded_wait)
    assert caller.call("ask", lambda: time.sleep(0.1) or 42, 5) == 42
    if caller._slice_s is None:
        assert waits == [5]
    else:
        assert len(waits) >= 3
        assert all(seconds <= 0.02 for seconds in waits)


def test_started_call_returns_later_and_delays_the_next(caller):
    release, order = threading.Event(), []
    future = caller.start("stream", lambda: release.wait(5) and order.append("begun"))
    assert not future.done()
    release.set()
    caller.call("read", lambda: order.append("next"), 5)
    assert order == ["begun", "next"]
    assert future.result(5) is None


def test_cancelled_call_does_not_run(caller):
    release, calls = threading.Event(), []
    caller.start("stream", lambda: release.wait(5))
    future = caller.start("read", lambda: calls.append("read"))
    assert future.cancel()
    release.set()
    caller.call("read", lambda: calls.append("next"), 5)
    assert calls == ["next"]


def test_urgent_call_skips_hanging_and_cancelled_calls(caller):
    release = threading.Event()
    caller.start("read", release.wait)
    with pytest.raises(DeviceTimeoutError):
        caller.call("set", lambda: None, 0.02)
    before = time.monotonic()
    assert caller.call_urgently("make safe", lambda: "safe", 60) == "safe"
    assert time.monotonic() - before < 10.0
    release.set()


def test_two_threads_may_wait_for_one_call(caller):
    release = threading.Event()
    pending = caller._send(release.wait)
    with ThreadPoolExecutor(2) as pool:
        waiting = [pool.submit(calling._is_over, pending, 5.0) for _ in range(2)]
        time.sleep(0.02)
        release.set()
        assert [future.result(60) for future in waiting] == [True, True]
    assert pending.result() is True


def test_negative_time_out_is_a_time_out(caller):
    release = threading.Event()
    with pytest.raises(DeviceTimeoutError):
        caller.call("read", release.wait, -0.1)
    release.set()


def test_first_hanging_call_is_named_after_later_ones_hang(caller):
    release = threading.Event()
    with pytest.raises(DeviceTimeoutError):
        caller.call("read", release.wait, 0.02)
    with pytest.raises(DeviceTimeoutError, match="'make safe' did not return"):
        caller.call_urgently("make safe", release.wait, 0.02)
    with pytest.raises(DeviceLostError, match="an earlier call, 'read', still hangs"):
        caller.call("set", lambda: None, 5)
    release.set()


def test_inline_caller_has_the_outcome_at_once():
    def refuse() -> None:
        raise TimeoutError("the instrument's own")

    caller = InlineCaller()
    assert caller.start("ask", lambda: 42).result(0) == 42
    with pytest.raises(TimeoutError, match="the instrument's own"):
        caller.start("ask", refuse).result(0)
