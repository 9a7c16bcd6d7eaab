"""Input of people and other programs to the queue, the panel and the listeners."""

from __future__ import annotations

import json
import re
import socket
import threading
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING
from urllib.parse import quote

import numpy as np
from starlette.testclient import TestClient
from target import Target

from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.api.errors import DeviceError, InvalidFileError, Problem
from rigrunner.procedure import check_result_limits, kinds_of, load_procedure
from rigrunner.queue import Queue, read_list
from rigrunner.registry import load_registry
from rigrunner.run.locate import shipped_folder
from rigrunner.station import load_station
from rigrunner_panel.web.app import make_app
from rigrunner_panel.web.panel import Panel, Settings
from rigrunner_plugins.listeners.mail import mail
from rigrunner_plugins.listeners.messages import Message
from rigrunner_plugins.listeners.notifier import DeliveryError
from rigrunner_plugins.listeners.settings import MailSettings, WebhookSettings
from rigrunner_plugins.listeners.webhook import webhook
from unit.rigrunner_plugins.equation.helpers_equation import instrument, run_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rigrunner.api.data import RunData
    from rigrunner.procedure import Procedure
    from rigrunner.registry import Registry
    from rigrunner_plugins.listeners.notifier import Notifier

QUEUE = """{"rigrunner": "queue/1", "next": 4, "entries": [
{"procedure": "starting_torque_1000n", "station": "rig", "inputs": {"specimen": "SN-1"},
 "operator": "Zoë", "partners": {"no_load": "R1"}, "realtime": true, "id": 1, "state": "closed",
 "by": "Ann", "added_utc": "2026-03-01T12:00:00.000Z", "run": "20260301T120000Z_A"},
{"procedure": "p.yaml", "station": "rig", "no_load": "R2", "id": 3, "state": "waiting", "by": "Ann",
 "added_utc": "2026-03-01T12:00:00.000Z", "reason": "", "repeats": 1, "repeated_by": "Zoë"}]}
"""
LISTS = (
    "SN-1\nSN-2\n",
    'specimen;type\nSN-1;GE20\n"SN-2";\n',
    "\ufeffspecimen\tlot\r\nSN-3\tL 7\r\n",
)
LISTENERS = """listeners:
  - plugin: mail
    settings: {host: smtp.example.org, user: rig-1, password: {env: PATH}, timeout: 2 s,
      attempts: 3, sender: rig-1@example.org, to: [lab@example.org], on: [run_ended, alarm]}
  - plugin: webhook
    settings: {url: "https://lab.example.org:8443/rigs?x=1", secret: {env: PATH}, wait: 20 s}
  - plugin: mqtt
    settings: {host: broker.example.org, port: 8883, tls: yes, topic: "rigs/{station}/{kind}"}
"""
HTTP = (
    b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\nok",
    b"HTTP/1.1 100 Continue\r\n\r\nHTTP/1.0 204 \r\nX: y\r\n z\r\n\r\n",
)
SMTP = b"".join(
    line + b"\r\n"
    for line in (
        b"220 mx ESMTP", b"250-mx", b"250-SIZE 100000", b"250 8BITMIME", b"250 sender", b"250 to",
        b"354 go", b"250 queued", b"221 bye",
    )
)  # fmt: skip
MODELS = (
    "R = U / I / (1 + alpha * (t - t_0))",
    "R = U / I\nP = R * I^2 * exp(-abs(U / number(1, V)))",
    "sqrt(max(U, number(2, V)) ** 2 + mean(U, 2*U)**2) / I * (1 + cos(pi * I/I) - atan2(U, U) / 1)",
)
UNITS = {"meter.voltage": "V", "meter.current": "A", "room.temperature": "K"}
INPUTS = {"U": "meter.voltage", "I": "meter.current", "t": "room.temperature"}
CONSTANTS = {"alpha": {"value": "0.00393 1/K", "limits": "±0.00005 1/K"}, "t_0": "20 °C"}
MESSAGE = Message(
    kind="alarm",
    utc="2026-03-01T12:00:00.000Z",
    station="rig",
    run="R",
    procedure="P",
    specimen="SN",
    text="hot",
)


LARGE = 10_000
"""Maximum size of a queue file in bytes."""


@cache
def _registry() -> Registry:
    """Return the registry of all plugins; making it anew would take most of the time."""
    return load_registry()


def _queue(path: Path) -> object:
    """Read a queue as the panel does to show it and to find its next entry."""
    runs = path.parent / "runs"
    runs.mkdir(exist_ok=True)
    (runs / "queue-rig.json").write_bytes(path.read_bytes())
    queue = Queue(runs)
    return queue.shown(), queue.next("rig")


@cache
def _procedure() -> Procedure:
    return load_procedure(shipped_folder() / "starting_torque_1000n.yaml").model


def _list(path: Path) -> object:
    return read_list(_text(path), _procedure().inputs)


def _text(path: Path) -> str:
    """Return the content of a file as a text that JSON can hold."""
    return path.read_bytes().decode("utf-8", "surrogateescape")


def _editor(path: Path) -> object:
    """Check an unsaved text as `checked_alone` does, with the cached registry."""
    procedure = path.parent / "edited.yaml"
    if not procedure.exists():
        procedure.write_bytes((shipped_folder() / "no_load_breakaway.yaml").read_bytes())
    loaded = load_procedure(procedure, kinds_of(_registry()), text=_text(path))
    check_result_limits(loaded, _registry())
    return loaded


def _equation(path: Path) -> object:
    """Check the text of a model as `check` does, and evaluate it as a run does."""
    model, registry = path.read_text("utf-8", "replace"), _registry()
    named = set(re.findall(r"\w+", model)) | {"U"}
    results = [
        {"name": f"result_{symbol}", "symbol": symbol, "unit": unit}
        for symbol, unit in {"R": "Ω", "P": "W"}.items()
        if symbol == "R" or symbol in named
    ]
    settings = {
        "results": results,
        "model": model,
        "inputs": {name: channel for name, channel in INPUTS.items() if name in named},
        "constants": {name: value for name, value in CONSTANTS.items() if name in named},
    }
    units = {channel: UNITS[channel] for channel in settings["inputs"].values()}
    if objections := registry.objections("equation", settings, units):
        raise InvalidFileError([Problem(message) for _, message, *_ in objections])
    return Scrutiny(registry).make("analysis", "equation", settings)(_run_data())


@cache
def _run_data() -> RunData:
    volt, ampere, kelvin = (x * np.array([1.0, 1.01, 0.98, 1.02]) for x in (5.0, 0.05, 296.0))
    columns = {"meter.voltage": volt, "meter.current": ampere, "room.temperature": kelvin}
    return run_of(columns, UNITS, (instrument("meter.voltage", "voltage", "2 mV"),))


def _editor_seeds(_: Path) -> list[bytes]:
    return [
        path.read_bytes()
        for path in sorted(shipped_folder().glob("*.yaml"))
        if b"call:" not in path.read_bytes()
    ]


TEXT = (shipped_folder() / "no_load_breakaway.yaml").read_text("utf-8")
PAIR = {"procedure": "starting_torque_1000n", "station": "simulated"}
LAB_PROCEDURE = {"procedure": "mine.yaml"}
REQUESTS: dict[str, dict[str, object]] = {
    "queue/add": {**PAIR, "list": "SN-1\nSN-2", "realtime": False},
    "queue/propose": {**PAIR, "inputs": {"specimen": "a"}, "operator": "Zoë", "by": "LIMS"},
    "queue/move": {"entry": 2, "before": 1},
    "queue/hold": {"entry": 1, "reason": "dirty"},
    "queue/release": {"entry": 1},
    "queue/skip": {"entry": 1, "reason": "lost"},
    "queue/repeat": {"entry": 1, "reason": "found"},
    "queue/clear": {},
    "procedures/edit": {**LAB_PROCEDURE, "by": "Ann"},
    "procedures/check": {**LAB_PROCEDURE, "text": TEXT, "station": "simulated_bench"},
    "procedures/save": {"procedure": "new.yaml", "text": TEXT, "by": "Ann"},
    "procedures/compare": {**LAB_PROCEDURE, "text": TEXT, "against": "file"},
    "plan": {**PAIR, "station": "simulated_bench", "text": TEXT},
    "check-input": {"procedure": PAIR["procedure"], "input": "specimen", "text": "SN-1"},
    "control": {"name": "Ann", "take_over": True},
}
"""Requests to the queue and the editor, by path."""


@cache
def _panel() -> tuple[TestClient, Path]:
    """Return a client of a panel with a lab folder, and its folder of runs."""
    lab = Path(mkdtemp()) / "lab"
    lab.mkdir()
    (lab / "mine.yaml").write_text(TEXT, "utf-8")
    panel = Panel(settings=Settings(runs=lab / "runs", procedures=lab))
    panel.rig("simulated")
    headers = {"X-Rigrunner-Client": "client-ann"}
    client = TestClient(make_app(panel), base_url="http://127.0.0.1:8750", headers=headers)
    return client, lab / "runs"


def _request(path: Path) -> object:
    """Post the file: a path in its first line, then the body.

    A bug raises, and so does a new file outside the folders of the lab.
    """
    endpoint, _, body = path.read_bytes().partition(b"\n")
    panel, runs = _panel()
    for queue in runs.glob("queue-*.json"):
        if queue.stat().st_size > LARGE:  # every request rewrites all earlier entries
            queue.unlink()
    panel.post("/api/v1/control", json={"name": "Ann", "take_over": True})
    address, headers = f"/api/v1/{quote(endpoint.strip())}", {"Content-Type": "application/json"}
    answer = panel.post(address, content=body, headers=headers)
    lab = runs.parent
    if [*lab.parent.iterdir()] != [lab] or [folder for folder in lab.glob("*/") if folder != runs]:
        raise RuntimeError("a request made files outside the folders of the lab")
    if answer.is_error:
        raise InvalidFileError([Problem(answer.text)])
    return answer.content


def _request_seeds(_: Path) -> list[bytes]:
    return [f"{endpoint}\n{json.dumps(body)}".encode() for endpoint, body in REQUESTS.items()]


@cache
def _station_text() -> bytes:
    return (shipped_folder() / "stations" / "simulated.yaml").read_bytes()


def _listeners(path: Path) -> object:
    """Make the listeners of a station as a run does, without sending events."""
    station = path.parent / "station.yaml"
    station.write_bytes(_station_text() + b"\n" + path.read_bytes())
    registry, sinks = _registry(), []
    with ExitStack() as open_sinks:
        for listener in load_station(station).model.listeners:
            sink = registry.make("event_sink", listener.plugin, listener.settings)
            open_sinks.callback(sink.close)  # type: ignore[attr-defined]
            sinks.append(sink)
    return sinks


def _answer_to(make: Callable[[int], Notifier]) -> Callable[[Path], object]:
    """Return a reader that sends a message to a server that answers with the file."""

    def read(path: Path) -> object:
        with answering(path.read_bytes()) as port:
            try:
                return make(port)._deliver(MESSAGE)
            except (DeliveryError, OSError) as error:
                raise DeviceError(str(error)) from error

    return read


@contextmanager
def answering(data: bytes) -> Iterator[int]:
    """Run a server on loopback that answers its first connection with these bytes."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = threading.Thread(target=_answer, args=(server, data))
        thread.start()
        try:
            yield server.getsockname()[1]
        finally:
            with suppress(OSError):  # if nobody connected
                socket.create_connection(server.getsockname(), 0.1).close()
            thread.join()


def _answer(server: socket.socket, data: bytes) -> None:
    with suppress(OSError):
        connection, _ = server.accept()
        with connection:
            connection.settimeout(0.5)
            connection.sendall(data)
            connection.shutdown(socket.SHUT_WR)
            while connection.recv(65536):
                pass


def _webhook_at(port: int) -> Notifier:
    return webhook(WebhookSettings(url=f"http://127.0.0.1:{port}/", timeout="1 s"))


def _mail_at(port: int) -> Notifier:
    sender, to = "rig@example.org", ("lab@example.org",)
    settings = {"host": "127.0.0.1", "port": port, "security": "none", "sender": sender, "to": to}
    return mail(MailSettings.model_validate({**settings, "timeout": "1 s"}))


LAB_TARGETS = (
    Target("queue", ".json", lambda _: [QUEUE.encode()], _queue),
    Target("list for the queue", ".csv", lambda _: [text.encode() for text in LISTS], _list),
    Target("text in the editor", ".yaml", _editor_seeds, _editor),
    Target("request to the panel", ".request", _request_seeds, _request),
    Target("equation", ".txt", lambda _: [text.encode() for text in MODELS], _equation),
    Target("listeners", ".yaml", lambda _: [LISTENERS.encode()], _listeners),
    Target("answer to a webhook", ".http", lambda _: [*HTTP], _answer_to(_webhook_at)),
    Target("answer to a mail", ".smtp", lambda _: [SMTP], _answer_to(_mail_at)),
)
