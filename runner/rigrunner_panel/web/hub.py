"""Sends changes and curves to every screen; a slow screen delays no other."""

from __future__ import annotations

import asyncio
from collections import deque
from contextlib import suppress
from functools import cache, partial
from typing import TYPE_CHECKING

from starlette.websockets import WebSocketDisconnect

from rigrunner_panel.control import short_name
from rigrunner_panel.view.rigs import Rigs
from rigrunner_panel.web import queueing
from rigrunner_panel.web.overview import rig_views
from rigrunner_panel.web.security import PROTOCOL

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from starlette.websockets import WebSocket

    from rigrunner_panel.live.curves import Curves
    from rigrunner_panel.web.panel import Panel, Rig

FRAME_S = 1 / 30
TREND_S = 0.1
RIGS_S = 0.25
IDLE_S = 1.0
MOST_WAITING = 64
"""Messages for a screen that is slow; with more it gets the whole state again instead."""


class Screen:
    """One WebSocket: what waits for it, bounded. Without a rig it gets the overview alone."""

    def __init__(self, socket: WebSocket, client: str, panel: Panel, rig: Rig | None) -> None:
        self.rig = rig
        self._socket = socket
        self._client = client
        self._panel = panel
        self._waiting: deque[str | bytes] = deque()
        self._lags = True
        self._news = asyncio.Event()
        self._news.set()

    def enqueue(self, message: str | bytes) -> None:
        """Send a message as soon as the screen takes it."""
        if self._lags:
            return
        if len(self._waiting) >= MOST_WAITING:
            self.begin_anew()
            return
        self._waiting.append(message)
        self._news.set()

    def begin_anew(self) -> None:
        """Forget what waits, and send the whole state instead."""
        self._waiting.clear()
        self._lags = True
        self._news.set()

    async def work(self) -> None:
        """Send until the screen is gone."""
        while True:
            await self._news.wait()
            self._news.clear()
            if self._lags:
                # Before it is sent: what changes meanwhile waits, and is sent after it.
                self._lags = False
                await self._send_all()
            while self._waiting:
                await self._send(self._waiting.popleft())

    async def _send_all(self) -> None:
        if self.rig is not None:
            state = self.rig.board.state(short_name(self._client))
            await self._send(f'{{"type":"state","state":{state}}}')
        await self._send(_rigs_message(self._panel))
        curves = self.rig.desk.curves if self.rig is not None else None
        for message in curves.all_frames() if curves is not None else ():
            await self._send(message)

    async def _send(self, message: str | bytes) -> None:
        if isinstance(message, str):
            await self._socket.send_text(message)
        else:
            await self._socket.send_bytes(message)


class Feed:
    """What is sent to the screens of one rig, and when."""

    def __init__(self, rig: Rig, screens: set[Screen]) -> None:
        self._rig = rig
        self._all_screens = screens
        self._curves: Curves | None = None
        self._trend_s = 0.0
        self._tick: asyncio.Future[None] | None = None

    def tick(self) -> None:
        """Do the periodic work of the rig."""
        self._rig.desk.tick()
        if self._tick is None or self._tick.done():  # in a thread: it reads and writes files
            self._tick = asyncio.ensure_future(asyncio.to_thread(queueing.tick, self._rig))

    def flush(self, now_s: float) -> bool:
        """Send what has changed; return whether more follows in a thirtieth of a second."""
        for event in self._rig.board.new_events():
            self._broadcast(event)
        delta = self._rig.board.delta()
        if delta is not None:
            self._broadcast(delta)
        curves = self._rig.desk.curves
        # Curves of another job: the screens must drop those that they have drawn.
        if curves is not self._curves:
            self._curves = curves
            for screen in self._screens():
                screen.begin_anew()
        return curves is not None and self._send_curves(curves, now_s)

    def _send_curves(self, curves: Curves, now_s: float) -> bool:
        curve = curves.next_curve()
        if curve is not None:
            self._broadcast(curve)
        if now_s - self._trend_s >= TREND_S:
            self._trend_s = now_s
            trend = curves.next_trend()
            if trend is not None:
                self._broadcast(trend)
        return curve is not None

    def _broadcast(self, message: str | bytes) -> None:
        for screen in self._screens():
            screen.enqueue(message)

    def _screens(self) -> Iterator[Screen]:
        return (screen for screen in self._all_screens if screen.rig is self._rig)


class Hub:
    """All screens, and the one task that sends to them."""

    def __init__(self, panel: Panel) -> None:
        self._panel = panel
        self._screens: set[Screen] = set()
        self._feed = cache(partial(Feed, screens=self._screens))
        self._wake = asyncio.Event()
        self._tick_s = self._rigs_s = 0.0
        self._rigs = ""
        self._look: asyncio.Future[None] | None = None

    async def run(self) -> None:
        """Send changes, at most thirty times a second, until cancelled."""
        loop = asyncio.get_running_loop()
        self._panel.wake = lambda: _call(loop, self._wake.set)
        while True:
            with suppress(TimeoutError):
                # `wait_for` loses a cancellation that comes with the news, until Python 3.12
                async with asyncio.timeout(IDLE_S):
                    await self._wake.wait()
            self._wake.clear()
            self._flush(loop.time())
            await asyncio.sleep(FRAME_S)

    async def serve(self, socket: WebSocket, client: str, rig: Rig | None) -> None:
        """Serve one screen until it is gone; what it sends is ignored."""
        screen = Screen(socket, client, self._panel, rig)
        offered = socket.scope.get("subprotocols", ())
        await socket.accept(PROTOCOL if PROTOCOL in offered else None)
        self._come(screen, client)
        work = asyncio.create_task(screen.work())
        gone = asyncio.create_task(_until_gone(socket))
        try:
            await asyncio.wait({work, gone}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._go(screen, client)
            for task in (work, gone):
                task.cancel()
                with suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError, OSError):
                    await task

    def _come(self, screen: Screen, client: str) -> None:
        self._screens.add(screen)
        if screen.rig is not None:
            screen.rig.control.count_connection(client, 1)

    def _go(self, screen: Screen, client: str) -> None:
        self._screens.discard(screen)
        if screen.rig is not None:
            screen.rig.control.count_connection(client, -1)

    def _flush(self, now_s: float) -> None:
        feeds = [self._feed(rig) for rig in self._panel.open_rigs()]
        if now_s - self._tick_s >= IDLE_S:
            self._tick_s = now_s
            for feed in feeds:
                feed.tick()
            if self._look is None or self._look.done():  # in a thread: it reads files
                self._look = asyncio.ensure_future(asyncio.to_thread(self._panel.tick))
        follows = [feed.flush(now_s) for feed in feeds]
        if self._screens and now_s - self._rigs_s >= RIGS_S:
            self._rigs_s = now_s
            before, self._rigs = self._rigs, _rigs_message(self._panel)
            for screen in self._screens if self._rigs != before else ():
                screen.enqueue(self._rigs)
        if any(follows):
            self._wake.set()


def _rigs_message(panel: Panel) -> str:
    rigs = Rigs(rigs=rig_views(panel.open_rigs()))
    return f'{{"type":"rigs",{rigs.model_dump_json()[1:]}'


async def _until_gone(socket: WebSocket) -> None:
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            return


def _call(loop: asyncio.AbstractEventLoop, function: Callable[[], object]) -> None:
    with suppress(RuntimeError):  # the loop is closed: no screen is connected any more
        loop.call_soon_threadsafe(function)
