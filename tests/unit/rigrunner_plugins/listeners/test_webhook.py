"""Messages to a web server: signed, retried where that helps, and never redirected."""

from __future__ import annotations

import base64
import hashlib
import hmac
import json

import pytest

from helpers_waiting import wait_until
from rigrunner.api import PluginError
from rigrunner.registry import load_registry
from rigrunner_plugins.listeners import notifier
from rigrunner_plugins.listeners.settings import Secret, WebhookSettings
from rigrunner_plugins.listeners.webhook import signature, signing_key, webhook
from unit.rigrunner_plugins.listeners.helpers_listeners import (
    SECRET,
    alarm,
    endless_answers,
    run_events,
    unresponsive,
    web,
)


@pytest.fixture(autouse=True)
def short_pauses(monkeypatch):
    monkeypatch.setattr(notifier, "FIRST_PAUSE_S", 0.01)
    monkeypatch.setattr(notifier, "LAST_WORDS_S", 1.0)
    monkeypatch.setenv("HOOK_KEY", SECRET)


def sink_to(port, **more):
    url = f"http://127.0.0.1:{port}/hook?rig=1"
    return webhook(WebhookSettings(url=url, **{"timeout": "2 s", "attempts": 3, **more}))


def test_signature_is_that_of_the_standard():
    """The example in the tests of the Standard Webhooks libraries."""
    key = signing_key("whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw")
    value = signature(key, "msg_p5jXN8AQM9LWM0D4loKWxJek", "1614265330", b'{"test": 2432232314}')
    assert value == "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE="


def test_receiver_gets_signed_json(tmp_path):
    with web() as (receiver, port):
        sink = sink_to(port, secret={"env": "HOOK_KEY"})
        for event in run_events(tmp_path):
            sink(event)
        sink.close()
    assert sink.lost == 0
    kinds = [json.loads(body)["kind"] for _, _, body in receiver.got]
    assert kinds == ["alarm", "run_ended"]
    path, headers, body = receiver.got[-1]
    document = json.loads(body)
    assert (document["station"], document["specimen"]) == ("rig-1", "SN-042")
    assert (path, headers["Content-Type"]) == ("/hook?rig=1", "application/json")
    signed = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + body
    expected = base64.b64encode(hmac.new(SECRET.encode(), signed, hashlib.sha256).digest()).decode()
    assert headers["webhook-signature"] == f"v1,{expected}"
    ids = [headers["webhook-id"] for _, headers, _ in receiver.got]
    assert len(set(ids)) == 2


def test_failing_receiver_is_retried_with_the_same_id():
    with web(500, 429, 200) as (receiver, port):
        sink = sink_to(port)
        sink(alarm())
        wait_until(lambda: len(receiver.got) == 3)
        sink.close()
    assert sink.lost == 0
    assert len({headers["webhook-id"] for _, headers, _ in receiver.got}) == 1
    assert "webhook-signature" not in receiver.got[0][1]


@pytest.mark.parametrize("status", [302, 400, 401, 404])
def test_refused_message_is_not_retried_and_no_redirect_is_followed(status):
    with web(status) as (receiver, port):
        sink = sink_to(port)
        sink(alarm())
        wait_until(lambda: sink.lost)
        sink.close()
    assert [path for path, _, _ in receiver.got] == ["/hook?rig=1"]


@pytest.mark.parametrize("closes", [True, False])
def test_receiver_that_hangs_or_closes_is_given_up(closes):
    with unresponsive(closes=closes) as port:
        sink = sink_to(port, timeout="0.1 s", attempts=2)
        sink(alarm())
        wait_until(lambda: sink.lost)
        sink.close()
    assert sink.lost == 1


@pytest.mark.parametrize(
    ("first", "again", "pause_s"),
    [
        (b"", b"HTTP/1.1 100 Continue\r\n\r\n" * 100, 0.0),
        (b"HTTP/1.1 2", b"0", 0.02),
        (b"HTTP/1.1 100 Continue\r\n", b"a: b\r\n", 0.02),
    ],
)
def test_endless_answer_is_given_up(first, again, pause_s):
    with endless_answers(first, again, pause_s) as port:
        sink = sink_to(port, timeout="0.3 s", attempts=1)
        sink(alarm())
        wait_until(lambda: sink.lost)
        sink.close()
    assert sink.lost == 1


def test_body_of_the_answer_is_not_read():
    with endless_answers(b"HTTP/1.1 200 OK\r\n\r\n", b"x" * 1000) as port:
        sink = sink_to(port, attempts=1)
        sink(alarm())
        sink.close()
    assert sink.lost == 0


def test_secret_is_read_when_the_run_starts_and_not_logged(tmp_path, monkeypatch):
    file = tmp_path / "key"
    file.write_text(f"{SECRET}\n", encoding="utf-8")
    assert Secret(file=str(file)).read() == SECRET
    monkeypatch.delenv("HOOK_KEY")
    with pytest.raises(PluginError, match="the variable HOOK_KEY is empty or not set"):
        sink_to(1, secret={"env": "HOOK_KEY"})
    with pytest.raises(PluginError, match="cannot read the file /no/such: FileNotFoundError"):
        Secret(file="/no/such").read()
    bad = "whsec_no*base64"
    monkeypatch.setenv("HOOK_KEY", bad)
    with pytest.raises(PluginError, match="not base64") as raised:
        sink_to(1, secret={"env": "HOOK_KEY"})
    assert bad not in str(raised.value)


@pytest.mark.parametrize(
    "settings",
    [
        {"url": "ftp://host/"},
        {"url": "https://user:word@host/"},
        {"url": "https://host/", "secret": SECRET},
        {"url": "https://host/", "secret": {}},
        {"url": "https://host/", "secret": {"env": "A", "file": "/b"}},
        {"url": "https://host/", "secret": {"file": "beside/the/station"}},
        {"url": "https://host/", "on": ["everything"]},
        {"url": "https://host/", "timeout": "5"},
    ],
)
def test_contradictory_settings_are_refused(settings):
    with pytest.raises(PluginError):
        load_registry().validated("event_sink", "webhook", settings)
