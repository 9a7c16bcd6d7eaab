"""The panel behind a real nginx with TLS, configured as documented, with a real browser."""

from __future__ import annotations

import datetime as dt
import json
import os
import re
import shutil
import socket
import ssl
import subprocess
import time
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import httpx
import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from e2e.panel.helpers_screen import WITHIN_S, Screen, free_port, running_panel
from helpers_docs import ROOT, code_blocks
from helpers_lacking import lacking

if TYPE_CHECKING:
    from pathlib import Path

HOST = "rig.example.org"
TOKEN = "correct-horse-battery"  # noqa: S105  (of a test)
PAGE = ROOT / "docs/how-to/panel-behind-a-proxy.md"
WITH_TOKEN = {"Authorization": f"Bearer {TOKEN}", "X-Rigrunner-Client": "client-ann"}
PASSES_ON = "      proxy_set_header Host $http_host;"


def nginx_path():
    """Return nginx, or skip: CI requires it."""
    path = shutil.which("nginx", path=f"{os.environ['PATH']}{os.pathsep}/usr/sbin")
    if path is None:
        lacking("NGINX", "there is no nginx: apt-get install nginx-light")
    return path


def write_certificate(folder):
    """Write a self-signed certificate for the name."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, HOST)])
    now = dt.datetime.now(dt.UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - dt.timedelta(days=1))
        .not_valid_after(now + dt.timedelta(days=1))
        .add_extension(x509.SubjectAlternativeName([x509.DNSName(HOST)]), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=None), critical=True)
        .sign(key, hashes.SHA256())
    )
    pem = serialization.Encoding.PEM
    (folder / "rig.pem").write_bytes(certificate.public_bytes(pem))
    unencrypted = (serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    (folder / "rig.key").write_bytes(key.private_bytes(pem, *unencrypted))


def configuration(folder, port, upstream):
    """Return the documented configuration, with the paths and ports of this test."""
    (text,) = (block.code for block in code_blocks(PAGE) if block.language == "nginx")
    places = "".join(
        f"  {name}_temp_path {folder}/{name};\n"
        for name in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    )
    for old, new in (
        ("http {\n", f"http {{\n{places}"),
        ("listen 443 ssl;", f"listen 127.0.0.1:{port} ssl;"),
        ("/etc/ssl/rig.example.org.pem", f"{folder}/rig.pem"),
        ("/etc/ssl/private/rig.example.org.key", f"{folder}/rig.key"),
        ("http://127.0.0.1:8750", upstream.rstrip("/")),
    ):
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


@dataclass(frozen=True)
class Proxy:
    """A running proxy in front of a panel."""

    port: int
    folder: Path
    panel: object

    @property
    def name(self):
        """Its name for a browser."""
        return f"{HOST}:{self.port}"

    @property
    def url(self):
        """Its address on this machine."""
        return f"https://127.0.0.1:{self.port}"

    def trusted(self):
        """Return an SSL context that trusts only its certificate."""
        return ssl.create_default_context(cafile=self.folder / "rig.pem")

    def get(self, path, **headers):
        """Send a request as a client of that name does."""
        headers = {"Host": self.name, **WITH_TOKEN, **headers}
        with httpx.Client(verify=self.trusted(), timeout=200) as client:
            return client.get(self.url + path, headers=headers, extensions={"sni_hostname": HOST})

    def events(self, origin):
        """Open the stream of events as a page of that origin does."""
        raw = socket.create_connection(("127.0.0.1", self.port), 20)
        return connect(
            f"wss://{self.name}/api/v1/events?client=client-ann&rig=station.yaml",
            sock=raw,
            ssl=self.trusted(),
            server_hostname=HOST,
            origin=origin,
            subprotocols=["rigrunner.v1", f"token.{TOKEN}"],
        )


@contextmanager
def running_proxy(lab, folder, change=lambda text: text):
    """Run a panel with a public name behind nginx until the block ends."""
    program, port = nginx_path(), free_port()
    write_certificate(folder)
    options = ("--public-name", f"{HOST}:{port}", "--token", TOKEN)
    with running_panel(lab, options=options) as panel:
        (folder / "nginx.conf").write_text(change(configuration(folder, port, panel.url)))
        command = [program, "-p", str(folder), "-c", str(folder / "nginx.conf")]
        command += ["-e", str(folder / "error.log"), "-g", f"daemon off; pid {folder}/nginx.pid;"]
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
            try:
                _wait_for(port, process)
                yield Proxy(port, folder, panel)
            finally:
                process.terminate()
                process.communicate(timeout=200)


def _wait_for(port, process):
    until_s = time.monotonic() + WITHIN_S
    while True:
        assert process.poll() is None, process.stderr.read()
        try:
            socket.create_connection(("127.0.0.1", port), 1).close()
        except OSError:
            assert time.monotonic() < until_s, "nginx does not listen"
            time.sleep(0.05)
        else:
            return


@pytest.fixture(scope="module")
def proxy(made_lab, tmp_path_factory):
    folder = tmp_path_factory.mktemp("proxy")
    with running_proxy(shutil.copytree(made_lab, folder / "lab"), folder) as running:
        yield running


def test_public_name_gets_answers_without_cookies(proxy):
    answer = proxy.get("/api/v1/rigs", Origin=f"https://{proxy.name}")
    assert answer.status_code == 200
    assert "set-cookie" not in answer.headers
    assert answer.headers["strict-transport-security"] == "max-age=31536000"
    assert proxy.get("/").status_code == 200


@pytest.mark.parametrize(
    ("headers", "status", "code"),
    [
        ({"Authorization": "Bearer wrong"}, 401, "no_token"),
        ({"Host": "evil.example"}, 403, "foreign_origin"),
        ({"Host": HOST}, 403, "foreign_origin"),  # without its port
        ({"Origin": "https://evil.example"}, 403, "foreign_origin"),
        ({"Origin": "null"}, 403, "foreign_origin"),
        ({"Sec-Fetch-Site": "cross-site"}, 403, "foreign_origin"),
    ],
)
def test_unauthorised_or_foreign_request_is_refused_through_the_proxy(proxy, headers, status, code):
    answer = proxy.get("/api/v1/rigs", **headers)
    assert (answer.status_code, answer.json()["code"]) == (status, code)


def test_origin_without_tls_is_refused(proxy):
    answer = proxy.get("/api/v1/rigs", Origin=f"http://{proxy.name}")
    assert (answer.status_code, answer.json()["code"]) == (403, "foreign_origin")


def test_events_arrive_by_websocket_over_tls(proxy):
    with proxy.events(f"https://{proxy.name}") as events:
        assert json.loads(events.recv(timeout=200))["type"] == "state"
    for origin in ("https://evil.example", f"http://{proxy.name}", f"https://{HOST}"):
        with pytest.raises(InvalidStatus) as caught, proxy.events(origin):
            pass
        assert caught.value.response.status_code == 403


def test_panel_behind_a_proxy_still_answers_locally(proxy):
    answer = httpx.get(f"{proxy.panel.url}api/v1/rigs", headers=WITH_TOKEN)
    assert answer.status_code == 200
    foreign = httpx.get(
        f"{proxy.panel.url}api/v1/rigs", headers={**WITH_TOKEN, "Host": "evil.example"}
    )
    assert foreign.json()["code"] == "foreign_origin"


def test_proxy_that_drops_the_host_header_gets_a_hint(lab, tmp_path):
    def without_host(text):
        assert PASSES_ON in text
        return re.sub(rf"{re.escape(PASSES_ON)}.*\n", "", text)

    with running_proxy(lab, tmp_path, without_host) as proxy:
        answer = proxy.get("/api/v1/rigs", Origin=f"https://{proxy.name}")
    assert answer.status_code == 403
    assert "proxy_set_header Host $http_host" in answer.json()["hint"]


@pytest.mark.thorough
def test_run_is_operated_in_a_browser_through_the_proxy(proxy, new_chromium):
    browser = new_chromium(f"--host-resolver-rules=MAP {HOST} 127.0.0.1")
    context = browser.new_context(
        ignore_https_errors=True, viewport={"width": 1280, "height": 720}, locale="en-GB"
    )
    context.set_default_timeout(1000 * WITHIN_S)
    panel = ProxiedPanel(f"https://{proxy.name}/", proxy.panel.folder)
    screen = Screen(context.new_page(), panel)
    sockets = []
    screen.page.on("websocket", lambda websocket: sockets.append(websocket.url))
    screen.open(f"#token={TOKEN}")
    screen.choose()
    screen.fill_in()
    screen.hurry()
    screen.check_rig()
    screen.start()
    screen.wait_for_result()
    assert context.cookies() == []
    assert sockets
    assert all(url.startswith(f"wss://{proxy.name}/") for url in sockets)
    assert screen.strangers == []
    assert screen.errors == []
    context.close()


@dataclass(frozen=True)
class ProxiedPanel:
    """The panel as the browser sees it."""

    url: str
    folder: Path
