"""The listeners that ship; each needs its extra once a station names it."""

from __future__ import annotations

from rigrunner.api import EventSinkRecord, Imported, hookimpl

_SETTINGS = "rigrunner_plugins.listeners.settings"
_NOBODY = {"attempts": 1, "timeout": "0.2 s"}
"""For a trial of the plugin, which must reach no one."""


@hookimpl
def rigrunner_event_sinks() -> list[EventSinkRecord]:
    """Return what notifies people who are away."""
    return [
        EventSinkRecord(
            name="webhook",
            help="Posts signed JSON to a web address",
            settings=f"{_SETTINGS}:WebhookSettings",
            factory=Imported("rigrunner_plugins.listeners.webhook:webhook"),
            trial={**_NOBODY, "url": "http://127.0.0.1:9/"},
        ),
        EventSinkRecord(
            name="mail",
            help="Sends mail",
            settings=f"{_SETTINGS}:MailSettings",
            factory=Imported("rigrunner_plugins.listeners.mail:mail"),
            trial={
                **_NOBODY,
                "host": "127.0.0.1",
                "port": 9,
                "sender": "rig@example.org",
                "to": ["lab@example.org"],
            },
        ),
        EventSinkRecord(
            name="mqtt",
            help="Publishes JSON to an MQTT broker",
            settings=f"{_SETTINGS}:MqttSettings",
            factory=Imported("rigrunner_plugins.listeners.mqtt:mqtt"),
        ),
        EventSinkRecord(
            name="apprise",
            help="Notifies desktops, phones and chats through the package apprise",
            settings=f"{_SETTINGS}:AppriseSettings",
            factory=Imported("rigrunner_plugins.listeners.chat:apprise"),
        ),
    ]
