"""Messages by apprise: to a service that takes JSON, on loopback."""

from __future__ import annotations

import json
from urllib.parse import parse_qs

import pytest

from helpers_waiting import wait_until
from rigrunner.api import PluginError
from rigrunner_plugins.listeners import notifier
from rigrunner_plugins.listeners.settings import AppriseSettings
from unit.rigrunner_plugins.listeners.helpers_listeners import (
    alarm,
    planned,
    run_events,
    unresponsive,
    web,
)

pytest.importorskip("apprise")


@pytest.fixture(autouse=True)
def short_pauses(monkeypatch):
    monkeypatch.setattr(notifier, "FIRST_PAUSE_S", 0.01)
    monkeypatch.setattr(notifier, "LAST_WORDS_S", 5.0)


@pytest.fixture
def sink_to(monkeypatch):
    from rigrunner_plugins.listeners.chat import apprise  # noqa: PLC0415  (an extra)

    def make(urls, **more):
        monkeypatch.setenv("URLS", urls)
        return apprise(AppriseSettings(urls={"env": "URLS"}, **{"attempts": 2, **more}))

    return make


def test_each_service_gets_the_messages(sink_to, tmp_path):
    with web() as (receiver, port):
        sink = sink_to(f"json://127.0.0.1:{port}/one\njson://127.0.0.1:{port}/two\n")
        for event in run_events(tmp_path):
            sink(event)
        sink.close()
    assert sink.lost == 0
    assert sorted(path for path, _, _ in receiver.got) == ["/one", "/one", "/two", "/two"]
    messages = [json.loads(body) for _, _, body in receiver.got]
    titles = {message["title"] for message in messages}
    assert "rig-1: run ended (completed, pass) - SN-042" in titles
    assert {(message["title"].split()[1], message["type"]) for message in messages} == {
        ("ALARM", "failure"), ("run", "info"),
    }  # fmt: skip


def test_failing_service_is_retried_and_its_address_not_logged(sink_to, caplog):
    with web(500) as (receiver, port):
        sink = sink_to(f"json://rig:s3cret@127.0.0.1:{port}/")
        sink(alarm())
        wait_until(lambda: sink.lost)
        sink.close()
    assert len(receiver.got) == 2
    assert "a service did not accept it" in caplog.text
    assert "s3cret" not in caplog.text


@pytest.mark.parametrize("closes", [True, False])
def test_service_that_hangs_or_closes_is_given_up(sink_to, closes):
    with unresponsive(closes=closes) as port:
        sink = sink_to(f"json://127.0.0.1:{port}/?cto=0.2&rto=0.2", attempts=1)
        sink(alarm())
        wait_until(lambda: sink.lost)
    assert sink.lost == 1


@pytest.mark.parametrize("form", ["html", "text"])
def test_html_service_gets_names_as_text(sink_to, tmp_path, form):
    with web() as (receiver, port):
        sink = sink_to(f"form://127.0.0.1:{port}/?format={form}")
        sink(planned(tmp_path))
        sink(alarm("<a href='http://evil.example'>hot</a>"))
        sink.close()
    body = receiver.got[0][2].decode()
    assert ("<a" in parse_qs(body)["message"][0]) == (form == "text")


def test_redirect_is_not_followed(sink_to):
    with web(302) as (receiver, port):
        sink = sink_to(f"json://127.0.0.1:{port}/", attempts=1)
        sink(alarm())
        wait_until(lambda: sink.lost)
        sink.close()
    assert [path for path, _, _ in receiver.got] == ["/"]


def test_address_unknown_to_apprise_is_refused_by_its_number(sink_to):
    with pytest.raises(PluginError, match="does not know address 2") as raised:
        sink_to("json://127.0.0.1/\nsecret-thing\n")
    assert "secret-thing" not in str(raised.value)


@pytest.mark.conformance("event_sink", "apprise")
def test_apprise_sink_conforms(conformance):
    conformance()


@pytest.fixture
def conformance_settings(monkeypatch):
    monkeypatch.setenv("URLS", "json://127.0.0.1:9/?cto=0.2&rto=0.2")
    return {"urls": {"env": "URLS"}, "attempts": 1}
