"""The description of the API: every route, every message, and every request of the screen."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from starlette.routing import Route, WebSocketRoute
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

import rigrunner_panel
from e2e.helpers_panel import parse_frame
from rigrunner.api.data import Block
from rigrunner.api.events import Note, Samples
from rigrunner.api.figures import Axis, Curve
from rigrunner_panel.live.curves import Curves
from rigrunner_panel.live.story import Story
from rigrunner_panel.process.messages import Show
from rigrunner_panel.view.sections import JobView, Phase, PlanView, State
from rigrunner_panel.web.app import make_app
from rigrunner_panel.web.operations import OPERATIONS
from rigrunner_panel.web.panel import Panel, Settings

ROOT = Path(__file__).parents[3]
SCRIPTS = sorted((Path(rigrunner_panel.__file__).parent / "static/js").rglob("*.js"))
ANN = {"X-Rigrunner-Client": "client-ann"}
EVENTS = "ws://127.0.0.1:8750/api/v1/events?client=client-ann"


@pytest.fixture
def panel(tmp_path):
    (tmp_path / "lab").mkdir()
    panel = Panel(settings=Settings(runs=tmp_path / "runs", procedures=tmp_path / "lab"))
    panel.rig("simulated")
    return panel


@pytest.fixture
def app(panel):
    return make_app(panel)


@pytest.fixture
def client(app):
    with TestClient(app, base_url="http://127.0.0.1:8750", headers=ANN) as client:
        yield client


@pytest.fixture
def description(client):
    return client.get("/api/v1/openapi.json").json()


def test_every_route_is_described_once_without_dangling_references(app, description):
    assert description["openapi"] == "3.1.0"
    served = {
        (method, route.path)
        for route in app.routes
        if isinstance(route, Route)
        for method in route.methods - {"HEAD"}
    }
    paths = {(method.upper(), path) for path, ops in description["paths"].items() for method in ops}
    assert paths == served
    assert len(served) == 1 + len(OPERATIONS)
    assert all(path.startswith("/api/v1/") for _, path in served)
    names = [op["operationId"] for ops in description["paths"].values() for op in ops.values()]
    assert len(set(names)) == len(names)
    references = set(re.findall(r'"#/components/schemas/([^"]+)"', json.dumps(description)))
    assert references <= set(description["components"]["schemas"])
    sockets = [route.path for route in app.routes if isinstance(route, WebSocketRoute)]
    assert sockets == ["/api/v1/events", "/{path:path}"]
    socket = description["paths"]["/api/v1/events"]["get"]
    assert {"client", "rig"} < {parameter["name"] for parameter in socket["parameters"]}
    assert set(socket["responses"]["101"]["content"]) == {
        "application/json",
        "application/octet-stream",
    }


def test_schemas_match_the_state_and_forbid_extra_fields(description, client):
    schemas = description["components"]["schemas"]
    assert set(schemas["State"]["required"]) == set(client.get("/api/v1/state").json())
    assert schemas["StartRun"]["additionalProperties"] is False


def test_every_socket_message_is_described(description, client, panel):
    schemas = description["components"]["schemas"]
    by_type = {item["properties"]["type"]["const"]: item for item in schemas["Message"]["oneOf"]}
    job = JobView(kind="run", procedure="p", station="s")
    story = Story(panel.rig("simulated").board, job, panel)
    kinds = set()
    with client.websocket_connect(EVENTS) as socket:
        story.take(Show({"plan": PlanView(estimated_s=1.0, steps=())}))
        story.take(Note(seq=0, monotonic_s=0, utc="", step="main[0]", text="a note"))
        while kinds != set(by_type):
            message = socket.receive_json()
            described = by_type[message["type"]]
            assert set(message) == set(described["required"])
            if message["type"] == "delta":
                changes = described["properties"]["changes"]
                assert set(message["changes"]) <= set(changes["properties"])
            kinds.add(message["type"])


def test_every_frame_header_is_described(description):
    schemas = description["components"]["schemas"]
    headers = {
        header["properties"]["kind"]["const"]: header for header in schemas["FrameHeader"]["oneOf"]
    }
    curves = Curves()
    block = Block(10.0, 0, 0.1, {"c.air": np.ones(9)})
    fields = {"seq": 0, "monotonic_s": 1.0, "utc": "", "recording": "001"}
    curves.take(Samples(block=block, **fields), 0.0, {})
    at = np.ones(2)
    curve = Curve(title="c", x=Axis("x"), y=Axis("y"), at=at, series={"": at}, end_s=1.0)
    curves.draw("001", curve, 1.0)
    shown = [parse_frame(frame_bytes)[0] for frame_bytes in curves.all_frames()]
    assert {header["kind"] for header in shown} == set(headers)
    for header in shown:
        described = headers[header["kind"]]
        assert set(described["required"]) <= set(header) <= set(described["properties"])


@pytest.mark.parametrize("method", ["GET", "POST", "DELETE"])
@pytest.mark.parametrize("path", ["/api/rigs", "/api/stop", "/api/v2/rigs", "/api/v1/rig"])
def test_path_without_version_gets_a_hint(client, method, path):
    answer = client.request(method, path, json={})
    assert (answer.status_code, answer.json()["code"]) == (404, "not_found")
    assert "/api/v1/openapi.json" in answer.json()["hint"]


def test_wrong_method_names_the_right_one(client):
    answer = client.get("/api/v1/stop")
    assert (answer.status_code, answer.headers["allow"]) == (405, "POST")
    assert answer.json()["message"] == "got GET, expected POST"


@pytest.mark.parametrize(
    "path", ["/api/events?client=client-ann", "/", "/api/v1/state", "/js/main.js"]
)
def test_socket_at_another_path_is_closed_with_a_hint(client, path):
    refused = pytest.raises(WebSocketDisconnect)
    with refused as closed, client.websocket_connect(f"ws://127.0.0.1:8750{path}"):
        pass
    assert (closed.value.code, closed.value.reason) == (4404, "the WebSocket is at /api/v1/events")


def test_api_page_lists_every_request_and_section():
    page = (ROOT / "docs/reference/panel-api.md").read_text(encoding="utf-8")
    requests = (ROOT / "docs/reference/panel-requests.md").read_text(encoding="utf-8")
    for operation in OPERATIONS:
        assert f"| `{operation.method} {operation.path}` |" in requests
    for section in State.model_fields:
        assert f"| `{section}` |" in page
    named = re.findall(r"`(?:GET|POST) (/api/[^`?]+)`", page)
    others = {"/api/v1/openapi.json"}
    assert set(named) - others <= {operation.path for operation in OPERATIONS}
    rows = re.findall(r"^\| `(\w+)`", page, re.MULTILINE)
    assert set(get_args(Phase)) <= set(rows)


METHODS = {"get": "GET", "post": "POST", "steer": "POST", "steerOrRefuse": "POST"}
_CALL = re.compile(
    r"(?<![.\w])(?<!function )(get|post|steer|steerOrRefuse)\((\"[^\"]*\"|`[^`]*`|\w+)"
)
_TEXT = re.compile(r"\"([^\"\n]*)\"|`([^`]*)`")
_VALUE = re.compile(r"const (\w+) = `([^`]*)`")


def _as_route(module, text):
    """Return a path in a script as a route, with '*' for each unknown part."""
    values = dict(_VALUE.findall(module))
    while named := re.search(r"\$\{(\w+)\}", text):
        text = text.replace(named[0], values.get(named[1], "*"))
    return re.sub(r"\$\{[^}]*\}", "*", text)


def _is_known(path, method=None):
    pattern = "".join("[^/]+" if part == "*" else re.escape(part) for part in path)
    operations = [operation for operation in OPERATIONS if method in (None, operation.method)]
    return any(re.fullmatch(f"/api/v1/{pattern}", operation.path) for operation in operations)


def test_screen_sends_only_described_requests():
    """The screen has no other way to ask: its requests go through two functions and one socket."""
    firsts = {operation.path.split("/")[3] for operation in OPERATIONS}
    requested = set()
    for script in SCRIPTS:
        module = script.read_text(encoding="utf-8")
        calls = re.findall(r"\b(fetch|WebSocket|XMLHttpRequest|EventSource|sendBeacon)\(", module)
        expected = {"client.js": ["fetch"] * 2, "texts.js": ["fetch"], "link.js": ["WebSocket"]}
        assert calls == expected.get(script.name, []), script
        for function, argument in _CALL.findall(module):
            if argument[0] in '"`':
                path = _as_route(module, argument[1:-1])
                assert _is_known(path, METHODS[function]), f"{script.name}: {function}({argument})"
                requested.add(path)
            elif script.name != "steer.js":  # a variable: check every text that may be a path
                prefixes = {text for _, text in _VALUE.findall(module)}
                texts = ("".join(match) for match in _TEXT.findall(module))
                routes = [_as_route(module, text) for text in texts if text not in prefixes]
                paths = [path for path in routes if path.split("/")[0] in firsts and "/" in path]
                assert all(map(_is_known, paths)), f"{script.name}: {paths}"
                requested |= set(paths)
    assert {"stop", "queue/hold", "run/repeat", "runs/*/certificates/*/sign", "*s"} <= requested
