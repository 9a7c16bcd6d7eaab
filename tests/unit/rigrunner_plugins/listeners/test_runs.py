"""Runs whose station names receivers: they get messages, and no receiver affects the run."""

from __future__ import annotations

import json
import time

import pytest

from helpers_tester import procedure_file, run, station_file
from helpers_thorough import first
from rigrunner.api import PluginError
from rigrunner.api.events import Alarm, Outcome, Samples
from rigrunner.runfile import read
from rigrunner_plugins.listeners import notifier
from unit.rigrunner_plugins.listeners.helpers_listeners import SECRET, unresponsive, web

pytestmark = pytest.mark.usefixtures("tester")


def lab(folder, *listeners):
    """Return a procedure and a station that names listeners, as YAML's flow mappings."""
    entries = "".join(f"\n  - {listener}" for listener in listeners)
    changed = ("id: bench\n", f"id: bench\nlisteners:{entries}\n")
    return procedure_file(folder, "idle"), station_file(folder, changed)


def hook(port, more=""):
    return (
        f"{{plugin: webhook, settings: {{url: 'http://127.0.0.1:{port}/',"
        f" secret: {{env: HOOK_KEY}}, disk_low_gb: 1e9{more}}}}}"
    )


@pytest.fixture(autouse=True)
def key(monkeypatch):
    monkeypatch.setenv("HOOK_KEY", SECRET)


def samples_of(finished):
    stored = read(finished.folder)
    return {rec.name: len(next(iter(rec.channels.values()))) for rec in stored.recordings}


def test_receiver_gets_messages_and_its_secret_is_in_no_file(tmp_path):
    with web() as (receiver, port):
        procedure, station = lab(tmp_path, hook(port))
        finished = run(procedure, tmp_path / "runs", station=station)
    assert finished.outcome is Outcome.COMPLETED
    messages = [json.loads(body) for _, _, body in receiver.got]
    assert [message["kind"] for message in messages] == ["disk_low", "run_ended"]
    assert (messages[1]["outcome"], messages[1]["run"]) == ("completed", finished.folder.name)
    assert messages[1]["station"] == "bench"
    assert (messages[1]["verdict"], "Verdict" in messages[1]["text"]) == ("", False), "it has none"
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert len(files) > 5
    assert not [path for path in files if SECRET.encode() in path.read_bytes()]


@pytest.mark.parametrize("closes", first(1, [False, True]))
def test_receiver_that_hangs_or_closes_does_not_affect_the_run(tmp_path, closes, caplog):
    (tmp_path / "quiet").mkdir()
    expected = run(procedure_file(tmp_path / "quiet", "idle"), tmp_path / "q")
    with unresponsive(closes=closes) as port:
        mail = (
            f"{{plugin: mail, settings: {{host: 127.0.0.1, port: {port}, security: none,"
            " sender: a@b, to: [c@d], disk_low_gb: 1e9}}"
        )
        procedure, station = lab(tmp_path, hook(port), mail)
        start_s = time.monotonic()
        finished = run(procedure, tmp_path / "runs", station=station)
    assert time.monotonic() - start_s < 60
    assert finished.outcome is Outcome.COMPLETED
    assert samples_of(finished) == samples_of(expected)
    stored = read(finished.folder).events
    events = [event for event in stored if isinstance(event, (Alarm, Samples))]
    assert events == []
    assert "webhook: 2 messages were not delivered" in caplog.text
    assert "mail: 2 messages were not delivered" in caplog.text
    assert SECRET not in caplog.text


def test_missing_secret_keeps_the_run_from_starting(tmp_path, monkeypatch):
    monkeypatch.delenv("HOOK_KEY")
    procedure, station = lab(tmp_path, hook(9))
    with pytest.raises(PluginError, match="the variable HOOK_KEY is empty or not set"):
        run(procedure, tmp_path / "runs", station=station)
    assert not list((tmp_path / "runs").glob("*"))


@pytest.fixture(autouse=True)
def short_pauses(monkeypatch):
    monkeypatch.setattr(notifier, "LAST_WORDS_S", 1.0)
