"""What many screens cost the panel: 200 live values at 10 Hz to 50 WebSockets.

    python tests/benchmarks/panel_watchers.py [screens] [values]

Not a test: it takes 10 s of real time, and prints the processor time of the server alone.
"""

from __future__ import annotations

import asyncio
import socket
import sys
import time
from multiprocessing import get_context
from pathlib import Path

import uvicorn
from websockets.asyncio.client import connect

from rigrunner_panel.live.story import Story
from rigrunner_panel.process.messages import Show, Values
from rigrunner_panel.serve import server_config
from rigrunner_panel.view.sections import ChannelView, JobView, PlanView
from rigrunner_panel.web.panel import Panel, Settings

SECONDS = 10.0


def watch(port, screens, got):
    """Be that many screens, which read what comes and do nothing with it."""

    async def one(number):
        address = f"ws://127.0.0.1:{port}/api/v1/events?client=watcher-{number:04d}&rig=simulated"
        async with connect(address, max_size=None) as screen:
            async for message in screen:
                got.value += len(message)

    async def every():
        await asyncio.wait_for(
            asyncio.gather(*(one(each) for each in range(screens))), SECONDS + 10
        )

    try:
        asyncio.run(every())
    except (TimeoutError, OSError):
        return


async def served(screens, values):
    """Return the share of a core that the server took, how many updates, and bytes received."""
    panel = Panel(settings=Settings(runs=Path("/nonexistent")))
    names = [f"rig_{i // 20}.channel_{i}" for i in range(values)]
    views = tuple(ChannelView(name=each, long_name="a channel", si="N", unit="N") for each in names)
    board = panel.rig("simulated").board
    story = Story(board, JobView(kind="run", procedure="p", station="s"), panel)
    story.take(Show({"plan": PlanView(estimated_s=1.0, steps=()), "channels": views}))
    listening = socket.create_server(("127.0.0.1", 0))
    server = uvicorn.Server(server_config(panel))
    work = asyncio.create_task(server.serve(sockets=[listening]))
    spawn = get_context("spawn")
    got = spawn.Value("Q")
    asked = (listening.getsockname()[1], screens, got)
    process = spawn.Process(target=watch, args=asked)
    process.start()
    while board.get("watchers") < screens:  # noqa: ASYNC110  (of another process)
        await asyncio.sleep(0.1)
    began, used = time.monotonic(), time.process_time()
    number = 0
    while time.monotonic() - began < SECONDS:
        number += 1
        now = {each: number + 0.123456 * i for i, each in enumerate(names)}
        story.take(Values(now, time.time(), 0.1))
        await asyncio.sleep(0.1)
    share = (time.process_time() - used) / (time.monotonic() - began)
    process.terminate()
    server.should_exit = True
    await work
    return share, number, got.value


if __name__ == "__main__":
    wanted = [int(each) for each in sys.argv[1:]] or [50, 200]
    found, updates, size = asyncio.run(served(*wanted))
    told = f"{100 * found:.0f} % of a core, {updates} updates, {size / 1e6:.0f} MB received"
    sys.stdout.write(f"{wanted}: {told}\n")
