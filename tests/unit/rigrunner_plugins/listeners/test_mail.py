"""Messages by mail, to a real server."""

from __future__ import annotations

import gc
import ssl
import warnings
from datetime import UTC, datetime, timedelta
from ipaddress import IPv4Address

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from helpers_waiting import wait_until
from rigrunner.api import PluginError
from rigrunner.registry import load_registry
from rigrunner_plugins.listeners import notifier
from rigrunner_plugins.listeners.mail import mail
from rigrunner_plugins.listeners.settings import MailSettings
from unit.rigrunner_plugins.listeners.helpers_listeners import (
    SECRET,
    alarm,
    endless_answers,
    finished,
    free_port,
    planned,
    run_events,
    unresponsive,
)

controllers = pytest.importorskip("aiosmtpd.controller")
smtp = pytest.importorskip("aiosmtpd.smtp")
DAY = timedelta(days=1)


@pytest.fixture(autouse=True)
def short_pauses(monkeypatch):
    monkeypatch.setattr(notifier, "FIRST_PAUSE_S", 0.01)
    monkeypatch.setattr(notifier, "LAST_WORDS_S", 5.0)
    monkeypatch.setenv("MAIL_WORD", SECRET)


class Handler:
    """Keeps received mail, or refuses it."""

    def __init__(self, *answers):
        self.got, self.attempts, self._answers = [], 0, list(answers)

    async def handle_DATA(self, _server, _session, envelope):  # noqa: N802  (aiosmtpd's name)
        self.attempts += 1
        if self._answers:
            return self._answers.pop(0)
        self.got.append(envelope)
        return "250 OK"


@pytest.fixture
def start_server():
    controllers_ = []

    def serve(handler, **more):
        controller = controllers.Controller(
            handler, hostname="127.0.0.1", port=free_port(), ready_timeout=30, **more
        )
        controller.start()
        controllers_.append(controller)
        return controller.port

    yield serve
    for controller in controllers_:
        controller.stop()
    with warnings.catch_warnings(action="ignore", category=ResourceWarning):
        gc.collect()  # asyncio does not close the socket of a handshake that failed


def sink_to(port, **more):
    base = {"host": "127.0.0.1", "port": port, "security": "none", "timeout": "2 s", "attempts": 3}
    people = {"sender": "rig@example.org", "to": ["lab@example.org", "chief@example.org"]}
    return mail(MailSettings(**{**base, **people, **more}))


def test_mail_has_the_messages_of_the_run(start_server, tmp_path):
    handler = Handler()
    sink = sink_to(start_server(handler))
    for event in run_events(tmp_path):
        sink(event)
    sink.close()
    assert sink.lost == 0
    letters = [message.content.decode() for message in handler.got]
    assert "Subject: rig-1: ALARM - SN-042" in letters[0]
    assert "Subject: rig-1: run ended (completed, pass) - SN-042" in letters[1]
    assert "The run ended: completed. Verdict: pass." in letters[1]
    assert handler.got[0].rcpt_tos == ["lab@example.org", "chief@example.org"]
    assert handler.got[0].mail_from == "rig@example.org"


def test_specimen_cannot_add_a_header(start_server, tmp_path):
    handler = Handler()
    sink = sink_to(start_server(handler), on=["run_ended"])
    sink(planned(tmp_path, inputs={"specimen": "SN\r\nBcc: all@example.org"}))
    sink(finished())
    sink.close()
    (letter,) = handler.got
    head = letter.content.decode().partition("\r\n\r\n")[0]
    assert not [line for line in head.splitlines() if line.startswith("Bcc")]


@pytest.mark.filterwarnings("ignore:Requiring AUTH while not requiring TLS")
def test_account_is_sent_to_the_server(start_server):
    logins = []

    def authenticate(_server, _session, _envelope, _mechanism, data):
        logins.append((data.login.decode(), data.password.decode()))
        return smtp.AuthResult(success=data.password.decode() == SECRET)

    more = {"authenticator": authenticate, "auth_require_tls": False, "auth_required": True}
    port = start_server(Handler(), **more)
    sink = sink_to(port, user="rig", password={"env": "MAIL_WORD"})
    sink(alarm())
    sink.close()
    assert (sink.lost, logins) == (0, [("rig", SECRET)])


def test_wrong_password_is_tried_once_and_not_logged(start_server, caplog):
    attempts = []

    def refuse(*_):
        attempts.append(1)
        return smtp.AuthResult(success=False, handled=False)

    port = start_server(Handler(), authenticator=refuse, auth_require_tls=False)
    sink = sink_to(port, user="rig", password={"env": "MAIL_WORD"})
    sink(alarm())
    wait_until(lambda: sink.lost)
    assert "the mail server said 535" in caplog.text
    assert SECRET not in caplog.text


def test_busy_server_is_retried_and_a_refusing_one_is_not(start_server):
    busy = Handler("451 later")
    sink = sink_to(start_server(busy))
    sink(alarm())
    wait_until(lambda: busy.got)
    refusing = Handler("554 no", "554 no", "554 no")
    other = sink_to(start_server(refusing))
    other(alarm())
    wait_until(lambda: other.lost)
    assert (sink.lost, busy.attempts, refusing.attempts) == (0, 2, 1)


@pytest.mark.parametrize("closes", [True, False])
@pytest.mark.parametrize("security", ["none", "starttls", "tls"])
def test_server_that_hangs_or_closes_is_given_up(closes, security):
    with unresponsive(closes=closes) as port:
        sink = sink_to(port, timeout="0.1 s", attempts=2, security=security)
        sink(alarm())
        wait_until(lambda: sink.lost)
        sink.close()
    assert sink.lost == 1


@pytest.mark.parametrize(
    ("first", "again", "pause_s"),
    [(b"220 mx\r\n", b"250-x\r\n" * 1000, 0.0), (b"", b"220-x\r\n", 0.02)],
)
def test_endless_answer_is_given_up(first, again, pause_s):
    with endless_answers(first, again, pause_s) as port:
        sink = sink_to(port, timeout="0.3 s", attempts=1)
        sink(alarm())
        wait_until(lambda: sink.lost)
        sink.close()
    assert sink.lost == 1


@pytest.fixture
def own_certificate(tmp_path):
    """A self-signed certificate, and the context of a server that has it."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "127.0.0.1")])
    now = datetime.now(UTC)
    alternative_name = x509.SubjectAlternativeName([x509.IPAddress(IPv4Address("127.0.0.1"))])
    certificate = (
        x509.CertificateBuilder(name, name, key.public_key(), 1, now - DAY, now + DAY)
        .add_extension(alternative_name, critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=None), critical=True)
        .sign(key, hashes.SHA256())
    )
    path, plain = tmp_path / "own.pem", serialization.NoEncryption()
    form = (serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, plain)
    (tmp_path / "key.pem").write_bytes(key.private_bytes(*form))
    path.write_bytes(certificate.public_bytes(serialization.Encoding.PEM))
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(path, tmp_path / "key.pem")
    return path, context


@pytest.mark.parametrize("security", ["starttls", "tls"])
def test_mail_over_tls_needs_a_trusted_certificate(
    start_server, own_certificate, monkeypatch, caplog, security
):
    path, context = own_certificate
    handler = Handler()
    of_tls = {"tls_context": context, "require_starttls": True}
    port = start_server(handler, **(of_tls if security == "starttls" else {"ssl_context": context}))
    untrusting = sink_to(port, security=security, attempts=1, timeout="30 s")
    untrusting(alarm())
    wait_until(lambda: "was not delivered" in caplog.text)
    assert (handler.got, untrusting.lost) == ([], 1)
    monkeypatch.setenv("SSL_CERT_FILE", str(path))
    sink = sink_to(port, security=security, attempts=1, timeout="30 s")
    sink(alarm())
    wait_until(lambda: handler.got or sink.lost)
    assert (len(handler.got), sink.lost) == (1, 0)


def test_server_without_tls_gets_nothing_in_clear_text(start_server):
    handler = Handler()
    sink = sink_to(start_server(handler), security="starttls", attempts=1)
    sink(alarm())
    wait_until(lambda: sink.lost)
    assert handler.attempts == 0


@pytest.mark.parametrize(
    "more", [{"to": []}, {"to": ["nobody"]}, {"sender": "a@b\nc"}, {"password": "x"}]
)
def test_contradictory_settings_are_refused(more):
    settings = {"host": "h", "sender": "a@b", "to": ["c@d"], **more}
    with pytest.raises(PluginError):
        load_registry().validated("event_sink", "mail", settings)
