"""The HTTP API: what it lists, plans and refuses. No rig is started here."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
from datetime import UTC, datetime
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from helpers_thorough import examples
from rigrunner.documents.certifying.withdraw import withdraw
from rigrunner.registry import load_registry
from rigrunner.run.locate import find_station
from rigrunner.tools.labfolder import make_lab
from rigrunner_panel.web import app, queueing
from rigrunner_panel.web.app import make_app
from rigrunner_panel.web.operation import SHORT
from rigrunner_panel.web.operations import OPERATIONS
from rigrunner_panel.web.panel import Panel, Settings
from rigrunner_panel.web.security import PAGE_POLICY

ROOT = Path(__file__).parents[3]

ANN = {"X-Rigrunner-Client": "client-ann"}
BOB = {"X-Rigrunner-Client": "client-bob"}
TOKEN = "correct-horse-battery"  # noqa: S105  (of a test)
EVENTS = "ws://127.0.0.1:8750/api/v1/events?client=client-ann"
PAIR = {"procedure": "no_load_inertia_sweep", "station": "simulated"}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "lab").mkdir()
    return tmp_path


def client_of(folder, **settings):
    options = {"runs": folder / "runs", "procedures": folder / "lab", **settings}
    panel = Panel(settings=Settings(**options))
    panel.rig("simulated")
    return TestClient(make_app(panel), base_url="http://127.0.0.1:8750", headers=ANN), panel


@pytest.fixture
def client(folder):
    test_client, _ = client_of(folder)
    with test_client:
        yield test_client


def test_procedures_and_stations_can_be_searched(client):
    names = [item["name"] for item in client.get("/api/v1/procedures").json()["items"]]
    assert "starting_torque_1000n" in names
    items = client.get("/api/v1/procedures", params={"search": "TORQUE STT-1000"}).json()["items"]
    assert [item["id"] for item in items] == ["SSPB-STT-1000"]
    stations = client.get("/api/v1/stations", params={"search": "bench"}).json()["items"]
    assert [item["name"] for item in stations] == ["simulated_bench", "simulated_loaded_bench"]


def test_files_of_the_lab_are_listed_by_path_with_problems(client, folder):
    (folder / "lab/station.yaml").write_text("rigrunner: station/1\nid: mine\n", encoding="utf-8")
    (folder / "lab/notes.yaml").write_text("anything: else\n", encoding="utf-8")
    items = client.get("/api/v1/stations").json()["items"]
    station = next(item for item in items if item["name"] == "station.yaml")
    assert not station["shipped"]
    assert "station.yaml" in station["problem"]
    assert not any("notes" in item["name"] for item in items)


def test_plan_describes_the_run(client):
    plan = client.post("/api/v1/plan", json=PAIR).json()
    assert plan["procedure"]["id"] == "SSPB-NLI"
    assert plan["station"]["simulated"]
    assert plan["estimated_s"] == pytest.approx(sum(step["estimated_s"] for step in plan["steps"]))
    torques = [reading for reading in plan["readings"] if reading["channel"] == "tester.torque"]
    assert [reading["cycle_frequency_hz"] for reading in torques][-1] == 35
    assert all(0 < reading["share"] < 1 for reading in torques)
    assert plan["partners"] == []


def test_plan_reports_a_missing_no_load_run(client):
    plan = client.post("/api/v1/plan", json={**PAIR, "procedure": "starting_torque_1000n"}).json()
    (partner,) = plan["partners"]
    assert (partner["name"], partner["words"], partner["run"]) == ("no_load", "no-load run", "")
    assert "SSPB-NLI" in partner["problem"] + partner["hint"]
    assert [item["name"] for item in plan["inputs"]] == ["specimen", "type", "lot", "operator"]


def test_problems_of_files_have_positions(client, folder):
    text = "rigrunner: procedure/2\nid: X\nrevision: A\ntitle: t\nmain: [{wait: x}]\nxx: 1\n"
    (folder / "lab/p.yaml").write_text(text, encoding="utf-8")
    answer = client.post("/api/v1/plan", json={"procedure": "p.yaml", "station": "simulated"})
    assert (answer.status_code, answer.json()["code"]) == (422, "invalid")
    assert any("p.yaml:6" in problem["where"] for problem in answer.json()["problems"])


@pytest.mark.parametrize(
    "name", ["../../etc/passwd", "/etc/passwd", "lab/../../x.yaml", "simulated\0", "x" * 200]
)
def test_path_is_refused_as_station_name(client, name):
    answer = client.post("/api/v1/plan", json={**PAIR, "station": name})
    assert (answer.status_code, answer.json()["code"]) == (404, "not_found")


def test_station_that_is_not_served_is_not_found(folder):
    client, _ = client_of(folder, stations=("simulated",))
    bench = "simulated_bench"
    with client:
        body = {**PAIR, "station": bench}
        answers = [
            client.get("/api/v1/state", params={"rig": bench}),
            client.get("/api/v1/procedures/schema", params={"station": bench}),
            client.post("/api/v1/plan", json=body),
            client.post("/api/v1/queue/propose", json={**body, "list": "SN-1", "by": "LIMS"}),
            client.post("/api/v1/control", json={"name": "Ann"}, params={"rig": bench}),
        ]
    assert [answer.status_code for answer in answers] == [404] * 5


def test_input_is_checked_as_it_is_typed(client):
    def check(text):
        body = {"procedure": "starting_torque_1000n", "input": "specimen", "text": text}
        return client.post("/api/v1/check-input", json=body).json()

    assert check(" SN-1 ")["value"] == "SN-1"
    assert (check("  ")["ok"], check("  ")["message"]) == (False, "nothing was given")


def test_watcher_without_client_id_is_refused(client):
    refused = pytest.raises(WebSocketDisconnect)
    with refused as closed, client.websocket_connect(f"{EVENTS[:-5]}!"):
        pass
    assert closed.value.code == 4400


STEERING = [operation for operation in OPERATIONS if operation.steers]
BODIES = {
    "/api/v1/preflight": PAIR,
    "/api/v1/run/start": PAIR,
    "/api/v1/run/answer": {"prompt": 1, "text": "yes"},
    "/api/v1/run/override": {"reason": "r"},
    "/api/v1/run/skip": {"reason": "r"},
    "/api/v1/run/note": {"text": "t"},
    "/api/v1/queue/add": PAIR,
    "/api/v1/queue/move": {"entry": 1},
    "/api/v1/queue/hold": {"entry": 1, "reason": "r"},
    "/api/v1/queue/release": {"entry": 1},
    "/api/v1/queue/skip": {"entry": 1, "reason": "r"},
    "/api/v1/queue/repeat": {"entry": 1, "reason": "r"},
    "/api/v1/queue/start": {"entry": 1},
    "/api/v1/queue/automatic": {"on": True},
    "/api/v1/manual/open": PAIR,
    "/api/v1/manual/set": {"drive": "tester.load", "value": "1 N"},
    "/api/v1/runs/{run}/certificate": {"authorised_by": "B"},
    "/api/v1/runs/{run}/certificates/{number}/amend": {"authorised_by": "B", "reason": "r"},
    "/api/v1/runs/{run}/certificates/{number}/withdraw": {"by": "B", "reason": "r"},
    "/api/v1/runs/{run}/certificates/{number}/sign": {"by": "B"},
}


@pytest.mark.parametrize("operation", STEERING, ids=lambda operation: operation.path)
def test_steering_requires_control(client, operation):
    body = BODIES.get(operation.path, {})
    assert client.post("/api/v1/control", json={"name": "Bob"}, headers=BOB).status_code == 200
    answer = client.post(operation.path.format(run="r", number="n"), json=body)
    assert (answer.status_code, answer.json()["code"]) == (403, "not_in_control")
    assert "Bob" in answer.json()["message"]


@pytest.mark.parametrize(
    "path",
    sorted(op.path for op in STEERING if op.path.startswith(("/api/v1/run/", "/api/v1/m"))),
)
def test_run_operations_are_refused_without_a_run(client, path):
    client.post("/api/v1/control", json={"name": "Ann"})
    answer = client.post(path, json=BODIES.get(path, {}))
    assert (answer.status_code, answer.json()["code"]) == (409, "wrong_state")
    assert answer.json()["message"]


def test_anyone_may_stop_and_learns_that_nothing_was_running(client):
    client.post("/api/v1/control", json={"name": "Bob"}, headers=BOB)
    assert client.post("/api/v1/stop", json={}).json() == {"ok": True, "stopped": False}


def test_control_is_taken_over_only_on_request(client):
    client.post("/api/v1/control", json={"name": "Bob"}, headers=BOB)
    assert client.post("/api/v1/control", json={"name": "Ann"}).status_code == 409
    assert (
        client.post("/api/v1/control", json={"name": "Ann", "take_over": True}).status_code == 200
    )
    state = client.get("/api/v1/state").json()
    assert (state["control"]["name"], state["control"]["client"]) == ("Ann", state["you"])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "JSON"),
        (b"{", "JSON"),
        (b"\xff\xfe", "JSON"),
        (b"[]", "object"),
        (b'{"name": 3}', "name"),
        (b'{"name": "Ann", "admin": true}', "admin"),
        (b'{"name": "   "}', "name"),
        (b'{"name": "' + b"x" * 101 + b'"}', "name"),
        (b"[" * 50_000, "JSON"),
    ],
)
def test_malformed_body_is_refused_with_a_message(client, content, words):
    answer = client.post(
        "/api/v1/control", content=content, headers={"Content-Type": "application/json"}
    )
    assert (answer.status_code, answer.json()["code"]) == (400, "bad_request")
    assert words in answer.json()["message"]


JSON = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.floats(allow_nan=False, allow_infinity=False),
        st.text(),
    ),
    lambda inner: st.one_of(st.lists(inner), st.dictionaries(st.text(), inner)),
    max_leaves=5,
)
TEXT = st.one_of(st.text(max_size=20), st.sampled_from(["simulated", "10 Hz", "../x", "\0"]))
POSTS = [op for op in OPERATIONS if op.body is not None and op.path != "/api/v1/control"]


@settings(
    max_examples=examples(150),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(data=st.data())
def test_arbitrary_bodies_get_a_documented_status(client, data):
    client.post("/api/v1/control", json={"name": "Ann", "take_over": True})
    operation = data.draw(st.sampled_from(POSTS))
    fields = {name: st.one_of(TEXT, JSON) for name in operation.body.model_fields}
    body = data.draw(st.one_of(st.fixed_dictionaries({}, optional=fields), JSON))
    answer = client.post(operation.path.format(run="r", number="n"), json=body)
    assert answer.status_code in {200, 202, 400, 404, 409, 422}, answer.text
    assert answer.json().get("code", "") != "bug"


def test_huge_body_is_refused(client):
    content = b'{"name": "' + b"x" * SHORT + b'"}'
    headers = {"Content-Type": "application/json"}
    answer = client.post("/api/v1/control", content=content, headers=headers)
    assert (answer.status_code, answer.json()["code"]) == (413, "too_long")
    chunks = 0

    def endless():
        nonlocal chunks
        while chunks < 100:
            chunks += 1
            yield b"x" * 16_384

    answer = client.post("/api/v1/control", content=endless(), headers=headers)
    assert answer.status_code == 413


def test_missing_body_times_out(client, monkeypatch):
    monkeypatch.setattr(app, "REQUEST_S", 0.1)

    headers = {**ANN, "content-type": "application/json"}
    scope = {
        "type": "http", "method": "POST", "path": "/api/v1/stop", "query_string": b"",
        "headers": [(name.lower().encode(), text.encode()) for name, text in headers.items()]
        + [(b"host", b"127.0.0.1:8750")],
    }  # fmt: skip
    messages, begun = [], []

    async def receive():
        if begun:
            await asyncio.Event().wait()
        begun.append(True)
        return {"type": "http.request", "body": b"{", "more_body": True}

    async def send(message):
        messages.append(message)

    asyncio.run(asyncio.wait_for(client.app(scope, receive, send), 20))
    assert messages[0]["status"] == 408
    assert json.loads(messages[1]["body"])["message"] == "the body did not come within 0.1 s"


@pytest.mark.parametrize(
    ("path", "query"),
    [("runs", {"limit": "9" * 5000}), ("trend", {"quantity": "x", "baseline": "9" * 5000})],
)
def test_number_too_long_for_python_is_refused(client, path, query):
    answer = client.get(f"/api/v1/{path}", params=query)
    assert (answer.status_code, answer.json()["code"]) == (400, "bad_request")


@pytest.mark.parametrize(
    "headers",
    [
        {"Content-Type": "text/plain"},
        {"Content-Type": "application/x-www-form-urlencoded"},
        {"X-Rigrunner-Client": ""},
        {"X-Rigrunner-Client": "a b c d e f g"},
        {"X-Rigrunner-Client": "x" * 65},
    ],
)
def test_post_that_a_foreign_form_could_send_is_refused(client, headers):
    headers_sent = {"Content-Type": "application/json", **headers}
    answer = client.post("/api/v1/stop", content=b"{}", headers=headers_sent)
    assert (answer.status_code, answer.json()["code"]) == (400, "bad_request")


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": "evil.example:8750"},
        {"Host": "127.0.0.1.evil.example"},
        {"Host": ""},
        {"Host": "192.0.2.7:8750"},
        {"Origin": "http://evil.example"},
        {"Origin": "http://127.0.0.1:9999"},
        {"Origin": "null"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
)
def test_requests_of_another_site_are_refused(client, headers):
    for answer in (
        client.get("/api/v1/state", headers=headers),
        client.post("/api/v1/stop", json={}, headers=headers),
    ):
        assert (answer.status_code, answer.json()["code"]) == (403, "foreign_origin")
    with client.websocket_connect(EVENTS) as socket:
        assert socket.receive_json()["type"] == "state"
    refused = pytest.raises(WebSocketDisconnect)
    with refused as closed, client.websocket_connect(EVENTS, headers=headers):
        pass
    assert closed.value.code == 4403


@pytest.mark.parametrize("headers", [{"Host": "[::1"}, {"Origin": "http://[::1"}])
def test_malformed_host_or_origin_is_refused(client, headers):
    answer = client.get("/api/v1/state", headers=headers)
    assert answer.status_code == 403
    assert answer.json()["code"] == "foreign_origin"


@pytest.mark.parametrize("host", ["localhost", "localhost:8750", "127.0.0.1:1", "[::1]:8750"])
def test_local_names_are_accepted_with_any_port(client, host):
    headers = {"Host": host, "Origin": f"http://{host}", "Sec-Fetch-Site": "same-origin"}
    assert client.get("/api/v1/state", headers=headers).status_code == 200


@pytest.mark.parametrize("public", ["rig.example.org", "rig.example.org:443", "Rig.Example.org"])
def test_public_name_is_accepted_with_and_without_its_port(folder, public):
    client, _ = client_of(folder, public_name=public)
    for host in ("rig.example.org", "rig.example.org:443", "RIG.example.org"):
        for origin in ("https://rig.example.org", "https://rig.example.org:443"):
            answer = client.get("/api/v1/state", headers={"Host": host, "Origin": origin})
            assert answer.status_code == 200, (host, origin)


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("rig.example.org:80", "https://rig.example.org"),
        ("rig.example.org", "http://rig.example.org"),
        ("rig.example.org", "https://rig.example.org:8443"),
        ("rig.example.org", "https://rig.example.org.evil.example"),
        ("rig.example.org", "https://evil.example"),
        ("rig.example.org", "null"),
        ("rig.example.org.evil.example", None),
        ("evil.example", None),
        ("127.0.0.1:8750", "https://rig.example.org"),
    ],
)
def test_names_other_than_the_public_one_are_refused(folder, host, origin):
    client, _ = client_of(folder, public_name="rig.example.org")
    headers = {"Host": host, **({"Origin": origin} if origin else {})}
    answer = client.get("/api/v1/state", headers=headers)
    assert (answer.status_code, answer.json()["code"]) == (403, "foreign_origin")


def test_answers_have_security_headers(client):
    for path in ("/", "/api/v1/state", "/nothing", "/api/v1/nothing"):
        answer = client.get(path)
        assert "access-control-allow-origin" not in answer.headers
        assert "set-cookie" not in answer.headers
        assert answer.headers["content-security-policy"] == PAGE_POLICY
        assert answer.headers["x-content-type-options"] == "nosniff"
    assert "unsafe" not in PAGE_POLICY
    preflight = client.options("/api/v1/stop", headers={"Access-Control-Request-Method": "POST"})
    assert preflight.status_code == 405


def test_only_pictures_of_prompts_are_served(folder):
    (folder / "lab/clamp.png").write_bytes(b"picture")
    client, panel = client_of(folder)
    address = panel.picture(str(folder / "lab/clamp.png"))
    assert client.get(address).content == b"picture"
    assert client.get("/api/v1/pictures/0123456789abcdef").status_code == 404
    assert client.get("/api/v1/pictures/..%2f..%2flab%2fclamp.png").status_code == 404
    (folder / "lab/clamp.png").unlink()
    assert client.get(address).status_code == 404


class TestWithAToken:
    @pytest.fixture
    def client(self, folder):
        test_client, _ = client_of(folder, token=TOKEN, host="0.0.0.0")  # noqa: S104  (not listened to)
        with test_client:
            yield test_client

    @pytest.mark.parametrize(
        "header", ["", "Bearer", "Bearer wrong", f"Basic {TOKEN}", f"Bearer {TOKEN}x", "Bearer é"]
    )
    def test_requests_without_token_are_refused(self, client, header):
        headers = {"Authorization": header.encode()} if header else {}
        for path in (
            "/api/v1/state",
            "/api/v1/runs",
            "/api/v1/runs/x/files/y?ticket=abc",
            "/api/v1/nothing",
        ):
            answer = client.get(path, headers=headers)
            assert (answer.status_code, answer.json()["code"]) == (401, "no_token")

    def test_requests_with_token_are_answered(self, client):
        headers = {"Authorization": f"Bearer {TOKEN}"}
        assert client.get("/api/v1/state", headers=headers).status_code == 200
        assert client.get("/api/v1/openapi.json").status_code == 200
        assert client.get("/").status_code == 200

    def test_non_ascii_ticket_is_refused(self, folder):
        _, panel = client_of(folder, token=TOKEN)
        assert not panel.admits("/api/v1/runs", "\u00e9")

    def test_websocket_sends_the_token_as_subprotocol(self, client):
        with client.websocket_connect(EVENTS, ["rigrunner.v1", f"token.{TOKEN}"]) as socket:
            assert socket.accepted_subprotocol == "rigrunner.v1"
            assert socket.receive_json()["type"] == "state"
        for offered in ([], ["rigrunner.v1"], ["token.wrong"]):
            refused = pytest.raises(WebSocketDisconnect)
            with refused as closed, client.websocket_connect(EVENTS, offered):
                pass
            assert closed.value.code == 4401

    def test_address_of_this_machine_is_accepted_and_foreign_name_refused(self, client):
        headers = {"Authorization": f"Bearer {TOKEN}"}
        answer = client.get("/api/v1/state", headers={**headers, "Host": "192.0.2.7:8750"})
        foreign = client.get("/api/v1/state", headers={**headers, "Host": "evil.example"})
        assert (answer.status_code, foreign.status_code) == (200, 403)


class TestHistory:
    @pytest.fixture
    def client(self, folder, demo):
        test_client, _ = client_of(folder, runs=demo.folder)
        with test_client:
            yield test_client

    def test_runs_are_listed_newest_first_with_results(self, client, demo):
        items = client.get("/api/v1/runs").json()["items"]
        assert [item["run"] for item in items] == [demo.loaded.name, demo.no_load.name]
        result = json.loads((demo.loaded / "result.json").read_text(encoding="utf-8"))
        headline = result["headline"]["compensated"]
        assert items[0]["verdict"] == result["decision"]["verdict"] == "pass"
        assert items[0]["headline"]["value"] == headline["value"]
        assert items[0]["headline"]["U"] == headline["expanded_uncertainty_95"]
        assert (items[0]["specimen"], items[0]["operator"]) == ("DEMO-0001", "Demo operator")

    def test_runs_can_be_searched_filtered_and_paged(self, client, demo):
        def runs(**query):
            return [
                item["run"] for item in client.get("/api/v1/runs", params=query).json()["items"]
            ]

        assert runs(search="demo-0001 STARTING") == [demo.loaded.name]
        assert runs(procedure="SSPB-NLI") == [demo.no_load.name]
        assert runs(verdict="fail") == []
        assert runs(before=demo.loaded.name) == [demo.no_load.name]
        first = client.get("/api/v1/runs", params={"limit": "1"}).json()
        assert (len(first["items"]), first["more"]) == (1, True)
        assert runs(limit="-3") == runs(limit="x") == runs()

    def test_run_has_its_result_events_and_files(self, client, demo):
        detail = client.get(f"/api/v1/runs/{demo.loaded.name}").json()
        assert detail["result"]["decision"]["verdict"] == "pass"
        assert detail["sealed"]
        assert any("run completed" in event["text"] for event in detail["events"])
        urls = {file["name"]: file["url"] for file in detail["files"]}
        assert set(urls) >= {"report.html", "result.json", "run.h5", "run.log"}
        report = client.get(urls["report.html"])
        assert report.content == (demo.loaded / "report.html").read_bytes()
        policy = report.headers["content-security-policy"]
        assert policy.startswith("sandbox; default-src 'none'")
        assert "script" not in policy

    def test_next_run_keeps_all_inputs_but_the_specimen(self, client, demo):
        again = client.get(f"/api/v1/runs/{demo.loaded.name}/again").json()
        assert again == {
            "procedure": "starting_torque_1000n",
            "station": "simulated",
            "inputs": {"type": "DEMO-GE20", "lot": "DEMO-LOT-1", "operator": "Demo operator"},
            "operator": "Demo operator",
        }

    def test_typed_specimen_with_earlier_run_gets_a_note(self, client, demo):
        body = {"procedure": "starting_torque_1000n", "input": "specimen"}
        notes = [
            client.post("/api/v1/check-input", json={**body, "text": text}).json()["note"]
            for text in ("demo-0001", "DEMO-0002")
        ]
        assert notes == [f"demo-0001 has already been tested: run {demo.loaded.name}", ""]

    def test_start_of_specimen_with_earlier_run_gets_a_note(self, client, demo, monkeypatch):
        started = []
        monkeypatch.setattr(queueing, "start_job", lambda *args, **_: started.append(args))
        assert client.post("/api/v1/control", json={"name": "Ann"}, headers=ANN).status_code == 200
        pair = {"procedure": "starting_torque_1000n", "station": "simulated"}
        for specimen, note in (
            ("demo-0001", f"demo-0001 has already been tested: run {demo.loaded.name}"),
            ("DEMO-0002", ""),
        ):
            body = {**pair, "inputs": {"specimen": specimen}}
            answer = client.post("/api/v1/run/start", json=body, headers=ANN)
            assert answer.json() == {"ok": True, "entry": None, "note": note}
        assert len(started) == 2

    def test_next_run_takes_the_same_of_two_stations_with_one_id(self, client, demo, folder):
        text = find_station("simulated").read_text(encoding="utf-8")
        changed = text.replace("seed: 1", "seed: 2")
        (folder / "lab" / "other.yaml").write_text(changed, encoding="utf-8")
        again = client.get(f"/api/v1/runs/{demo.loaded.name}/again").json()
        assert again["station"] == "simulated"

    def test_two_runs_are_compared_in_words(self, client, demo):
        query = {"before": demo.no_load.name, "after": demo.loaded.name}
        comparison = client.get("/api/v1/compare", params=query).json()
        assert not comparison["same"]
        assert any("specimen" in change["text"] for change in comparison["changes"])
        sections = [change["section"] for change in comparison["changes"]]
        assert (sections[0], sections.count("results") > 0) == ("results", True)
        same = dict.fromkeys(query, demo.loaded.name)
        assert client.get("/api/v1/compare", params=same).json()["same"]

    @pytest.mark.parametrize("how", ["resume", "recover"])
    def test_sealed_run_is_neither_resumed_nor_closed(self, client, demo, how):
        client.post("/api/v1/control", json={"name": "Ann"})
        answer = client.post(f"/api/v1/runs/{demo.loaded.name}/{how}", json={})
        assert (answer.status_code, answer.json()["code"]) == (422, "data")
        assert "has ended and is sealed" in answer.json()["message"]
        assert client.post("/api/v1/runs/nothing/recover", json={}).status_code == 404

    @pytest.mark.parametrize(
        "path",
        [
            "/api/v1/runs/..",
            "/api/v1/runs/%2e%2e",
            "/api/v1/runs/..%2f..%2fetc",
            "/api/v1/runs/{run}/files/..%2f..%2fsecret.txt",
            "/api/v1/runs/{run}/files/%2e%2e",
            "/api/v1/runs/{run}/files/....//secret.txt",
            "/api/v1/runs/{run}/files/run.h5%00",
            "/api/v1/runs/%2fetc/files/passwd",
            "/api/v1/runs/{run}/files/nothing.html",
            "/../../secret.txt",
            "/..%2f..%2fsecret.txt",
            "/static/../../secret.txt",
        ],
    )
    def test_files_outside_the_runs_are_not_served(self, client, demo, path):
        secret = demo.folder.parent / "secret.txt"
        secret.write_text("secret", encoding="utf-8")
        answer = client.get(path.format(run=demo.loaded.name))
        assert answer.status_code in (400, 404)
        assert b"secret" not in answer.content.replace(b"secret.txt", b"")

    @pytest.mark.skipif(not hasattr(os, "symlink"), reason="the system has no links")
    def test_links_and_unknown_files_in_a_run_are_not_served(self, folder, demo):
        shutil.copytree(demo.loaded, folder / "runs" / "r1")
        (folder / "secret.txt").write_text("secret", encoding="utf-8")
        (folder / "runs/r1/link.txt").symlink_to(folder / "secret.txt")
        (folder / "runs/r1/program.py").write_text("secret", encoding="utf-8")
        client, panel = client_of(folder)
        names = [path.name for path in panel.history.files("r1")]
        assert not {"link.txt", "program.py"} & set(names)
        for name in ("link.txt", "program.py"):
            assert client.get(f"/api/v1/runs/r1/files/{name}").status_code == 404

    def test_ticket_of_a_file_opens_no_other_file(self, folder, demo):
        client, _ = client_of(folder, runs=demo.folder, token=TOKEN)
        headers = {"Authorization": f"Bearer {TOKEN}"}
        detail = client.get(f"/api/v1/runs/{demo.loaded.name}", headers=headers).json()
        urls = {file["name"]: file["url"] for file in detail["files"]}
        assert client.get(urls["run.log"]).status_code == 200
        moved = urls["run.log"].replace("run.log", "result.json")
        assert client.get(moved).status_code == 401
        assert client.get(urls["run.log"].split("?")[0]).status_code == 401

    @pytest.mark.parametrize("what", ["verify", "amend", "withdraw", "sign"])
    @pytest.mark.parametrize("number", ["RR-2026-0001", "run", "%2e%2e"])
    def test_certificate_outside_the_run_is_not_touched(self, client, demo, what, number):
        client.post("/api/v1/control", json={"name": "Ann"})
        bodies = {
            "sign": {"by": "Ann"},
            "withdraw": {"by": "Ann", "reason": "r"},
            "amend": {"reason": "r", "authorised_by": "B. Boss"},
        }
        for run in (demo.loaded.name, "..", "no-such-run"):
            path = f"/api/v1/runs/{run}/certificates/{number}/{what}"
            assert client.post(path, json=bodies.get(what, {})).status_code in {404, 409, 422}, path

    def test_certificate_without_letterhead_is_refused(self, client, demo):
        client.post("/api/v1/control", json={"name": "Ann"})
        path = f"/api/v1/runs/{demo.loaded.name}/certificate"
        answer = client.post(path, json={"authorised_by": "B. Boss"})
        assert (answer.status_code, answer.json()["code"]) == (422, "usage")
        assert "letterhead" in answer.json()["message"]

    @pytest.mark.thorough
    def test_specimen_certificate_is_issued_with_its_files(self, folder, demo):
        shutil.copytree(demo.loaded, folder / "runs" / demo.loaded.name)
        make_lab(folder / "lab", load_registry())
        client, _ = client_of(folder, letterhead=folder / "lab/letterhead")
        client.post("/api/v1/control", params={"rig": "simulated"}, json={"name": "Ann"})
        order = {
            "customer": "C", "customer_contact": "c@example.org", "item": "bearing",
            "item_condition": "new", "received": "2026-01-01",
        }  # fmt: skip
        body = {"authorised_by": "B. Boss", "not_for_certification": True, "order": order}
        issued = client.post(f"/api/v1/runs/{demo.loaded.name}/certificate", json=body).json()
        assert issued["number"].startswith("SPECIMEN"), issued
        page = next(file for file in issued["files"] if file["name"].endswith(".html"))
        assert "B. Boss" in client.get(page["url"]).text

        for changes in ({}, {"language": "de"}, {"order": {**order, "customer": "Another"}}):
            again = client.post(f"/api/v1/runs/{demo.loaded.name}/certificate", json=body | changes)
            assert again.status_code == 422
            assert f"{issued['number']} exists" in again.json()["message"]
            assert "a further copy, with a reason" in again.json()["hint"]
        copy = body | {"further_copy": "in German", "language": "de"}
        further = client.post(f"/api/v1/runs/{demo.loaded.name}/certificate", json=copy).json()
        page = next(file for file in further["files"] if file["name"].endswith(".html"))
        assert f"Weiteres Exemplar neben {issued['number']}" in client.get(page["url"]).text

        withdraw(
            folder / "runs" / demo.loaded.name / f"{issued['number']}.json",
            folder / "lab/letterhead", by="B. Boss", reason="wrong", now=datetime.now(UTC),
        )  # fmt: skip
        items = client.get(f"/api/v1/runs/{demo.loaded.name}/certificates").json()["items"]
        assert items[0]["withdrawn"].startswith("withdrawn by B. Boss on 20")
        assert items[1]["withdrawn"] == ""
        path = f"/api/v1/runs/{demo.loaded.name}/certificates/{issued['number']}/verify"
        assert len(client.post(path, json={}).json()["withdrawn"]) == 1
