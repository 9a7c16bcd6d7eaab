"""A slow screen loses only its own old messages."""

from __future__ import annotations

import asyncio
import json

import pytest

from rigrunner_panel.web.hub import MOST_WAITING, Hub, Screen
from rigrunner_panel.web.panel import Panel, Settings


class SlowSocket:
    """Takes one message each time that the test releases it."""

    def __init__(self):
        self.ready = asyncio.Semaphore(0)
        self.received = []

    async def send_text(self, text):
        await self.ready.acquire()
        self.received.append(text)

    send_bytes = send_text


@pytest.fixture
def panel(tmp_path):
    return Panel(settings=Settings(runs=tmp_path, procedures=tmp_path))


def read(socket, count):
    async def work():
        for _ in range(count):
            socket.ready.release()
            await asyncio.sleep(0)
            await asyncio.sleep(0)

    return work()


async def working_screen(panel, messages):
    """Return a slow socket that has read nothing, its screen with these messages, and its work."""
    socket = SlowSocket()
    screen = Screen(socket, "client-slow-1", panel, panel.rig("simulated"))
    work = asyncio.create_task(screen.work())
    await asyncio.sleep(0)
    for message in messages:
        screen.enqueue(message)
    return socket, screen, work


def test_stalled_screen_queues_few_messages_then_gets_whole_state(panel):
    async def check():
        messages = [f"delta {n}" for n in range(10_000)]
        socket, screen, work = await working_screen(panel, messages)
        assert len(screen._waiting) <= MOST_WAITING
        panel.rig("simulated").board.put(phase="running")
        await read(socket, 4)
        screen.enqueue("after")
        await read(socket, 3)
        work.cancel()
        return socket.received

    got = asyncio.run(check())
    kinds = [json.loads(message)["type"] if message[0] == "{" else message for message in got]
    assert kinds == ["state", "rigs", "state", "rigs", "after"]
    assert json.loads(got[2])["state"]["phase"] == "running"


def test_screen_that_keeps_up_gets_every_message_in_order(panel):
    async def check():
        messages = [f"delta {n}" for n in range(MOST_WAITING)]
        socket, _, work = await working_screen(panel, messages)
        await read(socket, MOST_WAITING + 2)
        work.cancel()
        return socket.received

    got = asyncio.run(check())
    assert json.loads(got[0])["type"] == "state"
    assert got[2:] == [f"delta {n}" for n in range(MOST_WAITING)]


@pytest.mark.parametrize("turns", range(6))
def test_hub_ends_despite_a_change_during_cancellation(panel, turns):
    """A lost cancellation left the server waiting for ever when it was closed."""

    async def check():
        work = asyncio.create_task(Hub(panel).run())
        await asyncio.sleep(0.1)
        panel.rig("simulated").board.wake()
        for _ in range(turns):
            await asyncio.sleep(0)
        work.cancel()
        ended, _ = await asyncio.wait({work}, timeout=60)
        work.cancel()
        assert ended

    asyncio.run(check())
