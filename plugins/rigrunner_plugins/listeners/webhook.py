"""Posts messages as JSON, signed as https://www.standardwebhooks.com has it."""

from __future__ import annotations

import base64
import binascii
import hashlib
import hmac
import io
import json
import ssl
import time
from http.client import HTTPConnection, HTTPException, HTTPResponse, HTTPSConnection
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from rigrunner.api import PluginError
from rigrunner_plugins.listeners.answers import Answer
from rigrunner_plugins.listeners.notifier import DeliveryError, Notifier

if TYPE_CHECKING:
    import socket

    from rigrunner_plugins.listeners.messages import Message
    from rigrunner_plugins.listeners.settings import WebhookSettings

PREFIX = "whsec_"
_OK = range(200, 300)
_AGAIN = (408, 425, 429, *range(500, 600))


class _Response(HTTPResponse):
    """An answer that ends after a time: a receiver may say '100 Continue' for ever."""

    def __init__(self, sock: socket.socket, debuglevel: int = 0, method: str | None = None) -> None:
        super().__init__(sock, debuglevel, method)
        self.fp.close()
        self.fp = io.BufferedReader(Answer(sock))


def webhook(settings: WebhookSettings) -> Notifier:
    """Return the listener; raise PluginError where its secret cannot be read."""
    key = signing_key(settings.secret.read()) if settings.secret else b""
    try:
        parts = urlsplit(settings.url)
        port = parts.port
    except ValueError as error:
        raise PluginError(
            f"url: {error}", hint="such as https://lab.example.org:8443/runs"
        ) from error
    host, path = parts.hostname or "", parts.path or "/"
    target = f"{path}?{parts.query}" if parts.query else path

    def deliver(message: Message) -> None:
        body = json.dumps(message.document()).encode()
        connection: HTTPConnection
        if parts.scheme == "https":
            checked = ssl.create_default_context()
            connection = HTTPSConnection(host, port, timeout=settings.timeout, context=checked)
        else:
            connection = HTTPConnection(host, port, timeout=settings.timeout)
        connection.response_class = _Response
        try:
            connection.request("POST", target, body, headers(message, body, key))
            status = connection.getresponse().status
        except HTTPException as error:
            raise DeliveryError(f"the answer is not HTTP ({type(error).__name__})") from error
        finally:
            connection.close()
        if status not in _OK:
            raise DeliveryError(f"the receiver answered {status}", again=status in _AGAIN)

    return Notifier("webhook", settings, deliver)


def headers(message: Message, body: bytes, key: bytes) -> dict[str, str]:
    """Return what goes with a body. Each try of a message has the same id: it counts once."""
    digest = hashlib.sha256(repr(message).encode()).hexdigest()
    name, now = f"msg_{digest[:32]}", str(int(time.time()))
    fields = {
        "Content-Type": "application/json",
        "User-Agent": "rigrunner",
        "webhook-id": name,
        "webhook-timestamp": now,
    }
    return {**fields, "webhook-signature": signature(key, name, now, body)} if key else fields


def signature(key: bytes, name: str, timestamp: str, body: bytes) -> str:
    """Return 'v1,' and the HMAC-SHA256 of id, time and body in base64."""
    signed = b".".join((name.encode(), timestamp.encode(), body))
    return f"v1,{base64.b64encode(hmac.digest(key, signed, 'sha256')).decode()}"


def signing_key(secret: str) -> bytes:
    """Return the bytes of a secret: base64 behind 'whsec_', else the text itself."""
    if not secret.startswith(PREFIX):
        return secret.encode()
    try:
        return base64.b64decode(secret.removeprefix(PREFIX), validate=True)
    except binascii.Error as error:
        raise PluginError(
            "the secret is not base64 behind 'whsec_'", hint="copy it again"
        ) from error
