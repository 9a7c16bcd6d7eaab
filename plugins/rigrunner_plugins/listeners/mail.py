"""Sends messages by SMTP."""

from __future__ import annotations

import io
import smtplib
import ssl
from email.message import EmailMessage
from email.utils import formatdate, make_msgid
from typing import TYPE_CHECKING

from rigrunner_plugins.listeners.answers import Answer
from rigrunner_plugins.listeners.notifier import DeliveryError, Notifier

if TYPE_CHECKING:
    from rigrunner_plugins.listeners.messages import Message
    from rigrunner_plugins.listeners.settings import MailSettings

_FOR_GOOD = 500
"""From here on an answer of the server is not another one a moment later (RFC 5321, 4.2.1)."""


class _Server(smtplib.SMTP):
    """A mail server of which each answer ends after a time, whatever it sends."""

    _answer: Answer

    def getreply(self) -> tuple[int, bytes]:
        """Return the code and the text of an answer."""
        if self.file is None and self.sock is not None:  # at first, and where TLS has begun
            self._answer = Answer(self.sock)
            self.file = io.BufferedReader(self._answer)
        self._answer.begin()
        return super().getreply()


class _TlsServer(_Server, smtplib.SMTP_SSL):
    """The same with TLS from the beginning."""


def mail(settings: MailSettings) -> Notifier:
    """Return the listener; raise PluginError where its password cannot be read."""
    password = settings.password.read() if settings.password else ""

    def deliver(message: Message) -> None:
        letter = EmailMessage()
        letter["From"], letter["To"] = settings.sender, ", ".join(settings.to)
        letter["Subject"] = message.title
        letter["Date"] = formatdate(localtime=True)
        letter["Message-ID"] = make_msgid(domain=settings.sender.rpartition("@")[2])
        # So that no automatic answer, such as an absence note, is sent back (RFC 3834).
        letter["Auto-Submitted"] = "auto-generated"
        letter.set_content(message.body)
        try:
            with _connect(settings) as server:
                if settings.user:
                    server.login(settings.user, password)
                server.send_message(letter)
        except smtplib.SMTPRecipientsRefused as error:
            raise DeliveryError("the mail server refused every address", again=False) from error
        except smtplib.SMTPResponseException as error:  # its text may say the account
            again = error.smtp_code < _FOR_GOOD
            raise DeliveryError(f"the mail server said {error.smtp_code}", again=again) from error
        except smtplib.SMTPException as error:
            raise DeliveryError(f"the mail server: {type(error).__name__}") from error

    return Notifier("mail", settings, deliver)


def _connect(settings: MailSettings) -> smtplib.SMTP:
    host, port, timeout = settings.host, settings.port, settings.timeout
    if settings.security == "tls":
        checked = ssl.create_default_context()
        return _TlsServer(host, port, timeout=timeout, context=checked)
    server = _Server(host, port, timeout=timeout)
    if settings.security == "starttls":
        try:
            server.starttls(context=ssl.create_default_context())
        except BaseException:
            server.close()
            raise
    return server
