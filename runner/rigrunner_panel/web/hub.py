"""Tells every screen what changes: deltas and curves, none of which ever waits for a slow one."""

from __future__ import annotations

import asyncio
from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING

from starlette.websockets import WebSocketDisconnect

from rigrunner_panel.control import short_name
from rigrunner_panel.web import queueing
from rigrunner_panel.web.security import PROTOCOL

if TYPE_CHECKING:
    from collections.abc import Callable

    from starlette.websockets import WebSocket

    from rigrunner_panel.live.curves import Curves
    from rigrunner_panel.web.panel import Panel

FRAME_S = 1 / 30
TREND_S = 0.1
IDLE_S = 1.0
MOST_WAITING = 64
"""Messages for a screen that is slow; with more it gets the whole state anew instead."""


class Screen:
    """One WebSocket: what waits for it, bounded."""

    def __init__(self, socket: WebSocket, client: str) -> None:
        self._socket = socket
        self._client = client
        self._waiting: deque[str | bytes] = deque()
        self._lags = True
        self._news = asyncio.Event()
        self._news.set()

    def tell(self, message: str | bytes) -> None:
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

    async def work(self, panel: Panel) -> None:
        """Send until the screen is gone."""
        while True:
            await self._news.wait()
            self._news.clear()
            if self._lags:
                self._lags = False
                await self._send_all(panel)
            while self._waiting:
                await self._send(self._waiting.popleft())

    async def _send_all(self, panel: Panel) -> None:
        state = panel.board.state(short_name(self._client))
        await self._send(f'{{"type":"state","state":{state}}}')
        curves = panel.desk.curves
        for each in curves.whole() if curves is not None else ():
            await self._send(each)

    async def _send(self, message: str | bytes) -> None:
        if isinstance(message, str):
            await self._socket.send_text(message)
        else:
            await self._socket.send_bytes(message)


class Hub:
    """All screens, and the one task that tells them."""

    def __init__(self, panel: Panel) -> None:
        self._panel = panel
        self._screens: set[Screen] = set()
        self._wake = asyncio.Event()
        self._curves: Curves | None = None
        self._trend_s = self._tick_s = 0.0
        self._tick: asyncio.Future[None] | None = None

    async def run(self) -> None:
        """Tell what changes, at most thirty times a second, until cancelled."""
        loop = asyncio.get_running_loop()
        self._panel.board.wake = lambda: _call(loop, self._wake.set)
        while True:
            with suppress(TimeoutError):
                # `wait_for` loses a cancellation that comes with the news, until Python 3.12
                async with asyncio.timeout(IDLE_S):
                    await self._wake.wait()
            self._wake.clear()
            self._flush(loop.time())
            await asyncio.sleep(FRAME_S)

    async def serve(self, socket: WebSocket, client: str) -> None:
        """Serve one screen until it is gone; what it sends is not listened to."""
        screen = Screen(socket, client)
        offered = socket.scope.get("subprotocols", ())
        await socket.accept(PROTOCOL if PROTOCOL in offered else None)
        self._screens.add(screen)
        self._panel.control.connected(client, 1)
        work = asyncio.create_task(screen.work(self._panel))
        gone = asyncio.create_task(_until_gone(socket))
        try:
            await asyncio.wait({work, gone}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._screens.discard(screen)
            self._panel.control.connected(client, -1)
            for task in (work, gone):
                task.cancel()
                with suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError, OSError):
                    await task

    def _flush(self, now_s: float) -> None:
        if now_s - self._tick_s >= IDLE_S:
            self._tick_s = now_s
            self._panel.desk.tick()
            if self._tick is None or self._tick.done():  # in a thread: it reads and writes files
                self._tick = asyncio.ensure_future(asyncio.to_thread(_look_at_files, self._panel))
        for event in self._panel.board.new_events():
            self._tell(event)
        delta = self._panel.board.delta()
        if delta is not None:
            self._tell(delta)
        curves = self._panel.desk.curves
        if curves is not self._curves:
            self._curves = curves
            for screen in self._screens:
                screen.begin_anew()
        if curves is not None:
            self._tell_curves(curves, now_s)

    def _tell_curves(self, curves: Curves, now_s: float) -> None:
        swing = curves.next_swing()
        if swing is not None:
            self._tell(swing)
            self._wake.set()  # the next one of the same block follows in a thirtieth of a second
        if now_s - self._trend_s >= TREND_S:
            self._trend_s = now_s
            trend = curves.next_trend()
            if trend is not None:
                self._tell(trend)

    def _tell(self, message: str | bytes) -> None:
        for screen in self._screens:
            screen.tell(message)


async def _until_gone(socket: WebSocket) -> None:
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            return


def _look_at_files(panel: Panel) -> None:
    """See what other programs changed: the queue, and procedures that are being edited."""
    queueing.tick(panel)
    panel.editing.tick(panel.control, panel.now())


def _call(loop: asyncio.AbstractEventLoop, function: Callable[[], object]) -> None:
    with suppress(RuntimeError):  # the loop is closed: nobody watches any more
        loop.call_soon_threadsafe(function)
