"""Limits of idle and hoarded connections, so that Stop always gets one."""

from __future__ import annotations

import socket
import threading
import time
from contextlib import contextmanager

import pytest
import uvicorn

from rigrunner_panel.web import connections

HALF = b"GET / HTTP/1.1\r\nHost: localhost\r\nX-Half: "
WHOLE = b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"
PATIENT_S = 20.0


async def app(scope, receive, send):  # noqa: ARG001  (as ASGI has it)
    await send({"type": "http.response.start", "status": 204, "headers": []})
    await send({"type": "http.response.body", "body": b""})


@pytest.fixture
def address(monkeypatch):
    monkeypatch.setattr(connections, "REQUEST_S", 1.0)
    monkeypatch.setattr(connections, "MOST_OF_ONE", 5)
    config = uvicorn.Config(
        app, http=connections.Bounded, log_level="critical", lifespan="off", timeout_keep_alive=60
    )
    with socket.create_server(("127.0.0.1", 0)) as listener:
        server = uvicorn.Server(config)
        work = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
        work.start()
        yield listener.getsockname()
        server.should_exit = True
        work.join()


@contextmanager
def connect(address, content=b""):
    with socket.create_connection(address, PATIENT_S) as connection:
        connection.sendall(content)
        yield connection


def is_closed(connection):
    try:
        return connection.recv(1000) == b""
    except ConnectionError:
        return True


@pytest.mark.parametrize("content", [b"", HALF])
def test_incomplete_request_is_closed(address, content):
    with connect(address, content) as connection:
        assert is_closed(connection)


def test_incomplete_second_request_is_closed(address):
    with connect(address, WHOLE) as connection:
        assert connection.recv(1000).startswith(b"HTTP/1.1 204")
        connection.sendall(HALF)
        assert is_closed(connection)


def test_active_connection_stays_open(address):
    with connect(address) as connection:
        for pause_s in (1.5, 0.0):
            connection.sendall(WHOLE)
            assert connection.recv(1000).startswith(b"HTTP/1.1 204")
            time.sleep(pause_s)


def test_connections_of_one_address_are_limited(address, monkeypatch):
    monkeypatch.setattr(connections, "REQUEST_S", PATIENT_S)
    with (
        connect(address, WHOLE) as first,
        connect(address, WHOLE) as two,
        connect(address, WHOLE) as three,
        connect(address, WHOLE) as four,
        connect(address, WHOLE) as five,
    ):
        connected = (first, two, three, four, five)
        assert all(connection.recv(1000).startswith(b"HTTP/1.1 204") for connection in connected)
        with pytest.raises(ConnectionError), connect(address, WHOLE) as sixth:
            assert sixth.recv(1000) == b"HTTP"
        first.sendall(WHOLE)
        assert first.recv(1000).startswith(b"HTTP/1.1 204")
