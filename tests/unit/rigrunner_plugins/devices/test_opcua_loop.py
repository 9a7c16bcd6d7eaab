"""The thread that runs an asynchronous library for synchronous callers."""

from __future__ import annotations

import asyncio
import threading
import time

import pytest

from rigrunner_plugins.devices.opcua.session import LoopThread

FOREVER_S = 3600.0


@pytest.fixture
def loop():
    thread = LoopThread("test")
    yield thread
    thread.stop()


async def answer():
    await asyncio.sleep(0)
    return 42


def test_do_returns_the_result_or_raises_the_error(loop):
    async def fail():
        await asyncio.sleep(0)
        raise ZeroDivisionError

    assert loop.do(answer(), 5.0) == 42
    with pytest.raises(ZeroDivisionError):
        loop.do(fail(), 5.0)


def test_do_stops_waiting_at_its_timeout(loop):
    with pytest.raises(TimeoutError):
        loop.do(asyncio.sleep(FOREVER_S), 0.05)
    assert loop.do(answer(), 5.0) == 42


def test_waiting_callers_are_released_on_stop(loop):
    threading.Timer(0.1, loop.stop).start()
    with pytest.raises(ConnectionError, match="abandoned"):
        loop.do(asyncio.sleep(FOREVER_S), FOREVER_S)


def test_stop_ends_thread_and_tasks(loop):
    threads = threading.active_count()
    start_s = time.monotonic()
    task = asyncio.run_coroutine_threadsafe(asyncio.sleep(FOREVER_S), loop._loop)
    loop.stop()
    loop.stop()
    assert task.cancelled()
    assert time.monotonic() - start_s < 10.0
    assert threading.active_count() <= threads - 1
