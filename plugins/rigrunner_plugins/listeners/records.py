"""The listeners that ship; each needs its extra once a station names it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import EventSinkRecord, hookimpl

if TYPE_CHECKING:
    from rigrunner.api import EventSink
    from rigrunner_plugins.listeners.settings import (
        AppriseSettings,
        MailSettings,
        MqttSettings,
        WebhookSettings,
    )

_SETTINGS = "rigrunner_plugins.listeners.settings"
_NOBODY = {"attempts": 1, "timeout": "0.2 s"}
"""A try of the plugin reaches nobody."""


@hookimpl
def rigrunner_event_sinks() -> list[EventSinkRecord]:
    """Return what notifies people who are away."""
    return [
        EventSinkRecord(
            name="webhook",
            help="Posts signed JSON to a web address",
            settings=f"{_SETTINGS}:WebhookSettings",
            factory=_webhook,
            trial={**_NOBODY, "url": "http://127.0.0.1:9/"},
        ),
        EventSinkRecord(
            name="mail",
            help="Sends mail",
            settings=f"{_SETTINGS}:MailSettings",
            factory=_mail,
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
            factory=_mqtt,
        ),
        EventSinkRecord(
            name="apprise",
            help="Notifies desktops, phones and chats by the package apprise",
            settings=f"{_SETTINGS}:AppriseSettings",
            factory=_apprise,
        ),
    ]


def _webhook(settings: WebhookSettings) -> EventSink:
    from rigrunner_plugins.listeners.webhook import webhook  # noqa: PLC0415  (http, ssl)

    return webhook(settings)


def _mail(settings: MailSettings) -> EventSink:
    from rigrunner_plugins.listeners.mail import mail  # noqa: PLC0415  (smtplib, ssl)

    return mail(settings)


def _mqtt(settings: MqttSettings) -> EventSink:
    from rigrunner_plugins.listeners.mqtt import mqtt  # noqa: PLC0415  (an extra)

    return mqtt(settings)


def _apprise(settings: AppriseSettings) -> EventSink:
    from rigrunner_plugins.listeners.chat import apprise  # noqa: PLC0415  (an extra)

    return apprise(settings)
