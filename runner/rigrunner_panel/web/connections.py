"""Limits of connections: everyone who watches, and who stops a rig, must get one.

Before a request is complete, its sender is not known. A program that begins requests and does not
end them would otherwise hold connections without limit, and each takes one of the few files that a
process may have open.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from uvicorn.protocols.http.h11_impl import H11Protocol

if TYPE_CHECKING:
    import asyncio

REQUEST_S = 10.0
"""From the first byte of a request, or from the connection, until its head is there."""
MOST_OF_ONE = 100
"""Connections of one address; a browser has six, and one more for each page that is open."""


class Bounded(H11Protocol):
    """HTTP on a connection that ends if its next request does not come, or there are too many."""

    _patience: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as uvicorn has it
        """Begin to wait for a request; end the connection at once where there are too many."""
        super().connection_made(transport)
        if self._others() >= MOST_OF_ONE:
            transport.abort()
            return
        self._wait()

    def data_received(self, data: bytes) -> None:
        """Take what came; what begins a request is waited for until that is whole."""
        super().data_received(data)
        if self._is_busy():
            self._stop_waiting()
        elif self._patience is None:
            self._wait()

    def on_response_complete(self) -> None:
        """Go on, if another request has begun to come; else uvicorn waits for it."""
        self._stop_waiting()
        super().on_response_complete()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no longer."""
        self._stop_waiting()
        super().connection_lost(exc)

    def _others(self) -> int:
        host = self.client[0] if self.client else ""
        clients = [getattr(connection, "client", None) for connection in self.connections]
        return [client[0] for client in clients if client].count(host) - 1

    def _is_busy(self) -> bool:
        """Return whether a request is being answered, or the connection is a WebSocket's by now."""
        answering = self.cycle is not None and not self.cycle.response_complete
        return answering or self.transport.get_protocol() is not self

    def _wait(self) -> None:
        self._patience = self.loop.call_later(REQUEST_S, self._give_up)

    def _stop_waiting(self) -> None:
        if self._patience is not None:
            self._patience.cancel()
            self._patience = None

    def _give_up(self) -> None:
        self._patience = None
        if not self._is_busy():
            self.transport.abort()
