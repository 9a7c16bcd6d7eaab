"""Messages to a real MQTT broker, where mosquitto is installed."""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import threading
from contextlib import contextmanager

import pytest

from helpers_waiting import wait_until
from rigrunner_plugins.listeners import notifier
from rigrunner_plugins.listeners.settings import MqttSettings
from unit.rigrunner_plugins.listeners.helpers_listeners import (
    SECRET,
    alarm,
    free_port,
    run_events,
    unresponsive,
)

paho = pytest.importorskip("paho.mqtt.client")

BROKER = shutil.which("mosquitto", path=f"{os.environ.get('PATH', '')}:/usr/sbin")
WORDS = shutil.which("mosquitto_passwd")
with_broker = pytest.mark.skipif(not BROKER or not WORDS, reason="mosquitto is not installed")


@pytest.fixture(autouse=True)
def short_pauses(monkeypatch):
    monkeypatch.setattr(notifier, "FIRST_PAUSE_S", 0.01)
    monkeypatch.setattr(notifier, "LAST_WORDS_S", 5.0)
    monkeypatch.setenv("MQTT_WORD", SECRET)


@contextmanager
def broker(folder, *lines):
    port = free_port()
    file = folder / "mosquitto.conf"
    file.write_text(
        "\n".join(["user root", f"listener {port} 127.0.0.1", *lines, ""]), encoding="utf-8"
    )
    process = subprocess.Popen([BROKER, "-c", str(file)], stderr=subprocess.DEVNULL)
    try:
        wait_until(lambda: answers(port))
        yield port
    finally:
        process.terminate()
        process.wait()


def answers(port):
    try:
        socket.create_connection(("127.0.0.1", port), 1).close()
    except OSError:
        return False
    return True


@contextmanager
def subscribed(port, user="", word=""):
    messages, ready = [], threading.Event()
    client = paho.Client(paho.CallbackAPIVersion.VERSION2)
    client.on_connect = lambda *_: client.subscribe("#", qos=1)
    client.on_subscribe = lambda *_: ready.set()
    client.on_message = lambda _client, _data, message: messages.append(message)
    if user:
        client.username_pw_set(user, word)
    client.connect("127.0.0.1", port)
    client.loop_start()
    try:
        assert ready.wait(30)
        yield messages
    finally:
        client.disconnect()
        client.loop_stop()


def sink_to(port, **more):
    from rigrunner_plugins.listeners.mqtt import mqtt  # noqa: PLC0415  (an extra)

    settings = {"host": "127.0.0.1", "port": port, "timeout": "5 s", "attempts": 2}
    return mqtt(MqttSettings(**{**settings, **more}))


@with_broker
def test_broker_forwards_the_messages(tmp_path):
    with broker(tmp_path, "allow_anonymous true") as port, subscribed(port) as messages:
        sink = sink_to(port)
        for event in run_events(tmp_path):
            sink(event)
        sink.close()
        assert sink.lost == 0
        wait_until(lambda: len(messages) == 2)
    topics = [message.topic for message in messages]
    assert topics == ["rigrunner/rig-1/alarm", "rigrunner/rig-1/run_ended"]
    document = json.loads(messages[1].payload)
    assert (document["verdict"], document["run"]) == ("pass", "R1")


@with_broker
def test_account_is_required_and_not_logged(tmp_path, caplog):
    password_file = tmp_path / "words"
    subprocess.run([WORDS, "-b", "-c", str(password_file), "rig", SECRET], check=True)
    password_file.chmod(0o644)
    lines = "allow_anonymous false", f"password_file {password_file}"
    with broker(tmp_path, *lines) as port, subscribed(port, "rig", SECRET) as messages:
        without_account = sink_to(port)
        without_account(alarm())
        wait_until(lambda: without_account.lost)
        sink = sink_to(port, user="rig", password={"env": "MQTT_WORD"})
        sink(alarm())
        sink.close()
        wait_until(lambda: len(messages) == 1)
    assert (sink.lost, without_account.lost) == (0, 1)
    assert "the broker refused the connection: Not authorized" in caplog.text
    assert SECRET not in caplog.text


@with_broker
def test_broker_that_returns_gets_the_message(tmp_path, monkeypatch):
    monkeypatch.setattr(notifier, "FIRST_PAUSE_S", 0.5)
    port = free_port()
    sink = sink_to(port, attempts=10)
    sink(alarm())
    file = tmp_path / "again.conf"
    file.write_text(f"listener {port} 127.0.0.1\nallow_anonymous true\n", encoding="utf-8")
    process = subprocess.Popen([BROKER, "-c", str(file)], stderr=subprocess.DEVNULL)
    try:
        wait_until(lambda: not sink._works)
    finally:
        process.terminate()
        process.wait()
    assert sink.lost == 0


@pytest.mark.parametrize("closes", [True, False])
def test_broker_that_hangs_or_closes_is_given_up(closes):
    with unresponsive(closes=closes) as port:
        sink = sink_to(port, timeout="0.2 s")
        sink(alarm())
        wait_until(lambda: sink.lost)
        sink.close()
    assert sink.lost == 1


def test_broker_that_accepts_and_closes_is_retried(caplog):
    accepted = bytes([0x20, 2, 0, 0])  # CONNACK of MQTT 3.1.1, without an error
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.settimeout(60.0)
        addresses = []

        def work():
            for _ in range(2):
                connection, address = listener.accept()
                addresses.append(address)
                connection.recv(1000)
                connection.sendall(accepted)
                connection.close()

        thread = threading.Thread(target=work)
        thread.start()
        sink = sink_to(listener.getsockname()[1], timeout="3 s", attempts=2)
        sink(alarm())
        wait_until(lambda: sink.lost)
        sink.close()
        thread.join()
    assert len(addresses) == 2
    assert "the broker closed the connection" in caplog.text or "did not confirm" in caplog.text


@pytest.mark.conformance("event_sink", "mqtt", {"host": "127.0.0.1", "port": 9, "attempts": 1})
def test_mqtt_sink_conforms(conformance):
    conformance()
