"""Reaches desktops, phones and chats by the package apprise."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import PluginError
from rigrunner_plugins.devices.extras import missing_package
from rigrunner_plugins.listeners.notifier import DeliveryError, Notifier

if TYPE_CHECKING:
    from rigrunner_plugins.listeners.messages import Message
    from rigrunner_plugins.listeners.settings import AppriseSettings, When

_TYPES: dict[When, str] = {
    "run_ended": "info",
    "waits_for_answer": "warning",
    "alarm": "failure",
    "disk_low": "warning",
    "calibration_due": "warning",
}
"""How a service marks a message, such as by a colour."""


def apprise(settings: AppriseSettings) -> Notifier:
    """Return the listener; raise PluginError without apprise, or where it knows no address."""
    try:
        from apprise import Apprise, AppriseAsset, NotifyFormat  # noqa: PLC0415  (an extra)
    except ImportError as error:
        raise missing_package("apprise", "apprise") from error
    asset = AppriseAsset(plugin_paths=[])  # of no folder of a user
    asset.http_redirects = False  # unless an address says redirect=yes
    services = Apprise(asset=asset)
    for number, url in enumerate(settings.urls.read().splitlines(), 1):
        if url.strip() and not services.add(url.strip()):
            raise PluginError(
                f"apprise does not know address {number} of its addresses",
                hint="https://appriseit.com/services lists the forms",
            )

    def deliver(message: Message) -> None:
        fields = {"title": message.title, "body": message.body, "notify_type": _TYPES[message.kind]}
        if not services.notify(**fields, body_format=NotifyFormat.TEXT):  # no name is HTML
            raise DeliveryError("a service did not accept it")

    return Notifier("apprise", settings, deliver)
