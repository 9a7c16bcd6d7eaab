"""The thread that runs an asynchronous library for callers that wait."""

from __future__ import annotations

import asyncio
import threading
import time

import pytest

from rigrunner_plugins.devices.opcua.session import LoopThread

FOREVER_S = 3600.0


@pytest.fixture
def loop():
    running = LoopThread("test")
    yield running
    running.stop()


async def answer():
    await asyncio.sleep(0)
    return 42


def test_it_returns_what_comes_and_raises_what_is_raised(loop):
    async def fail():
        await asyncio.sleep(0)
        raise ZeroDivisionError

    assert loop.do(answer(), 5.0) == 42
    with pytest.raises(ZeroDivisionError):
        loop.do(fail(), 5.0)


def test_it_waits_no_longer_than_it_may(loop):
    with pytest.raises(TimeoutError):
        loop.do(asyncio.sleep(FOREVER_S), 0.05)
    assert loop.do(answer(), 5.0) == 42


def test_whoever_waits_is_let_go_when_it_is_stopped(loop):
    threading.Timer(0.1, loop.stop).start()
    with pytest.raises(ConnectionError, match="abandoned"):
        loop.do(asyncio.sleep(FOREVER_S), FOREVER_S)


def test_nothing_is_left_of_it(loop):
    before = threading.active_count()
    began_s = time.monotonic()
    task = asyncio.run_coroutine_threadsafe(asyncio.sleep(FOREVER_S), loop._loop)
    loop.stop()
    loop.stop()
    assert task.cancelled()
    assert time.monotonic() - began_s < 10.0
    assert threading.active_count() <= before - 1
