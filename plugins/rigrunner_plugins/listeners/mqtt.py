"""Publishes messages as JSON to an MQTT broker, which has to confirm each of them."""

from __future__ import annotations

import json
import threading
from typing import TYPE_CHECKING, Any

from rigrunner_plugins.devices.extras import missing_package
from rigrunner_plugins.listeners.notifier import DeliveryError, Notifier

if TYPE_CHECKING:
    from rigrunner_plugins.listeners.messages import Message
    from rigrunner_plugins.listeners.settings import MqttSettings

AT_LEAST_ONCE = 1


def mqtt(settings: MqttSettings) -> Notifier:
    """Return the listener; raise PluginError without paho, or where no password can be read."""
    try:
        from paho.mqtt import client as paho  # noqa: PLC0415  (an extra)
    except ImportError as error:
        raise missing_package("paho-mqtt", "mqtt") from error
    password = settings.password.read() if settings.password else None

    def deliver(message: Message) -> None:
        # An attempt is one connection: the next one is the notifier's, which counts and waits.
        client = paho.Client(paho.CallbackAPIVersion.VERSION2, reconnect_on_failure=False)
        client.connect_timeout = settings.timeout
        if settings.user:
            client.username_pw_set(settings.user, password)
        if settings.tls:
            client.tls_set()
        connected, refused = threading.Event(), []

        def on_connect(_client: Any, _data: Any, _flags: Any, reason: Any, _more: Any) -> None:
            if reason.is_failure:
                refused.append(str(reason))
            connected.set()

        client.on_connect = on_connect
        client.connect(settings.host, settings.port)
        client.loop_start()
        try:
            if not connected.wait(settings.timeout):
                raise DeliveryError("the broker did not answer")
            if refused:
                raise DeliveryError(f"the broker refused the connection: {refused[0]}")
            topic = settings.topic.replace("{station}", message.station)
            topic = topic.replace("{kind}", message.kind)
            _publish(client, topic, message, settings.timeout)
            client.disconnect()
        finally:
            client.loop_stop()

    return Notifier("mqtt", settings, deliver)


def _publish(client: Any, topic: str, message: Message, timeout_s: float) -> None:
    """Publish a message; raise DeliveryError where the broker does not confirm it in time."""
    receipt = client.publish(topic, json.dumps(message.document()), qos=AT_LEAST_ONCE)
    try:
        receipt.wait_for_publish(timeout_s)
    except (RuntimeError, ValueError) as error:  # in which paho says that it cannot send
        raise DeliveryError("the broker closed the connection") from error
    if not receipt.is_published():
        raise DeliveryError("the broker did not confirm it")
