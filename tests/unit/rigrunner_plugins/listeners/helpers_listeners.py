"""Events of a run, and receivers that answer, refuse, hang or close."""

from __future__ import annotations

import socket
import threading
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from rigrunner.api.events import Alarm, Outcome, RunEnded, RunFinished, RunPlanned

UTC = "2026-11-23T12:00:00.000Z"
SECRET = "s3cret-of-the-test"  # noqa: S105  (of a test)


def event(kind, **fields):
    return kind(**{"seq": 0, "monotonic_s": 0.0, "utc": UTC, **fields})


def planned(folder, **more):
    base = {"run_id": "R1", "folder": str(folder), "station": "rig-1", "procedure": "P-7"}
    return event(RunPlanned, **{**base, "title": "Test", "inputs": {"specimen": "SN-042"}, **more})


def alarm(text="too hot"):
    return event(Alarm, source="interlock hot", text=text)


def ended():
    return event(RunEnded, outcome=Outcome.COMPLETED)


def finished():
    return event(RunFinished, outcome=Outcome.COMPLETED, verdict="pass")


def run_events(folder):
    return [planned(folder), alarm(), ended(), finished()]


def free_port():
    """Return a free port of loopback."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        return free.getsockname()[1]


class Receiver:
    """The requests of a web server, and its statuses in order; the last one is repeated."""

    def __init__(self, statuses):
        self.got = []
        self._statuses = list(statuses)

    def answer(self, path, headers, body):
        self.got.append((path, headers, body))
        return self._statuses.pop(0) if len(self._statuses) > 1 else self._statuses[0]


@contextmanager
def web(*statuses):
    """Serve on loopback; yield the receiver and its port."""
    receiver = Receiver(statuses or (200,))

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self):
            body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
            self.send_response(receiver.answer(self.path, dict(self.headers), body))
            self.send_header("Content-Length", "0")
            self.send_header("Location", "/elsewhere")
            self.end_headers()

        do_GET = do_POST  # noqa: N815  (http.server's name)

        def log_message(self, *_):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    try:
        yield receiver, server.server_address[1]
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


@contextmanager
def unresponsive(*, closes):
    """Listen on loopback and never answer, or close each connection at once."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.settimeout(0.05)
        connections, over = [], threading.Event()

        def work():
            while not over.is_set():
                try:
                    connection, _ = listener.accept()
                except TimeoutError:
                    continue
                if closes:
                    connection.close()
                connections.append(connection)

        thread = threading.Thread(target=work)
        thread.start()
        try:
            yield listener.getsockname()[1]
        finally:
            over.set()
            thread.join()
            for connection in connections:
                connection.close()


@contextmanager
def endless_answers(first, again, pause_s=0.0):
    """Answer each connection on loopback with `first`, and then with `again` for ever."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.settimeout(0.05)
        over, threads = threading.Event(), []

        def answer(connection):
            with connection, suppress(OSError):
                connection.settimeout(0.1)
                connection.sendall(first)
                while not over.wait(pause_s):
                    with suppress(TimeoutError):
                        connection.sendall(again)

        def work():
            while not over.is_set():
                with suppress(TimeoutError):
                    connection, _ = listener.accept()
                    threads.append(threading.Thread(target=answer, args=(connection,)))
                    threads[-1].start()

        thread = threading.Thread(target=work)
        thread.start()
        try:
            yield listener.getsockname()[1]
        finally:
            over.set()
            for thread_ in (thread, *threads):
                thread_.join()
