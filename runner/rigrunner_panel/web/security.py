"""Access control: the server's own hosts and origins, a token, and a client id.

A page of somebody else's, open in the same browser, must get nothing and do nothing: neither by a
request of its own (Origin, Sec-Fetch-Site), nor by a name of its own that it lets point here (Host,
DNS rebinding). There are no cookies, so that nothing is sent along unasked.
"""

from __future__ import annotations

import hmac
import ipaddress
import re
import socket
from typing import TYPE_CHECKING
from urllib.parse import SplitResult, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse

from rigrunner.api.errors import UsageError
from rigrunner_panel.errors import PanelError
from rigrunner_panel.web.operation import API

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from rigrunner_panel.web.panel import Panel

_PUBLIC_NAME = re.compile(r"(?=.{1,253}$)[A-Za-z0-9]([A-Za-z0-9.-]*[A-Za-z0-9])?(:[0-9]{1,5})?")
CLIENT = re.compile(r"[A-Za-z0-9_-]{8,64}")
PROTOCOL = "rigrunner.v1"
_TOKEN_PROTOCOL = "token."  # noqa: S105  (the name of a field, no token)
_OPEN = (f"{API}/openapi.json",)
PAGE_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "font-src 'self'; connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'"
)
HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
}


class Guard:
    """ASGI middleware: refuses foreign hosts and origins, and sets the headers of security."""

    def __init__(self, app: ASGIApp, panel: Panel) -> None:
        self._app = app
        self._panel = panel
        self._names = _own_names(panel.settings.host)
        self._is_local = is_loopback(panel.settings.host)
        self._public = panel.settings.public_name

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on a request that may be made; answer all others."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        try:
            self._check(scope)
        except PanelError as error:
            await _refuse(error, scope, receive, send)
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
                headers.setdefault("Content-Security-Policy", PAGE_POLICY)
                headers.setdefault("Cache-Control", "no-store")
            await send(message)

        await self._app(scope, receive, with_headers)

    def _check(self, scope: Scope) -> None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if not self._is_own(host):
            hint = f"open the panel by the address that it printed, not by '{host[:80]}'"
            raise PanelError(403, "foreign_origin", "the panel does not have this host name", hint)
        origin = headers.get("origin")
        if origin is not None and not self._is_same(origin, host):
            raise PanelError(403, "foreign_origin", *self._foreign(origin))
        path = scope["path"]
        if not path.startswith("/api") or path in _OPEN:
            return
        if headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
            raise PanelError(
                403, "foreign_origin", "requests from pages of other sites are refused"
            )
        if self._panel.settings.token and not self._has_token(scope, headers):
            hint = "Authorization: Bearer TOKEN, as the panel printed it"
            raise PanelError(401, "no_token", "the token is missing or wrong", hint)

    def _is_same(self, origin: str, host: str) -> bool:
        """Return whether a page of that origin is the panel's own, as the Host has it.

        By the public name it came through TLS: a page without it is from a machine on the way.
        """
        page = _split(origin)
        if self._is_public(host):
            return page.scheme == "https" and self._is_public(page.netloc)
        return page.netloc.casefold() == host.casefold()

    def _foreign(self, origin: str) -> tuple[str, str]:
        """Return what is wrong with an origin, and what to do where a proxy may be at fault."""
        if self._is_public(_split(origin).netloc):
            hint = "the proxy must pass the Host on: proxy_set_header Host $http_host"
            return "the host name of the request differs from that of its page", hint
        return "requests from pages of other sites are refused", ""

    def _is_public(self, netloc: str) -> bool:
        """Return whether this is the public name, with its port; 443 may be left out."""
        return bool(self._public) and _with_port(netloc) == _with_port(self._public)

    def _is_own(self, host: str) -> bool:
        """Return whether a Host is a name or an address of this server; a port may be forwarded."""
        if self._is_public(host):
            return True
        name = (_split(f"//{host}").hostname or "").casefold()
        if name in self._names:
            return True
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return False
        # An address cannot be made to point elsewhere, as a name can: it needs no list.
        return address.is_loopback or not self._is_local

    def _has_token(self, scope: Scope, headers: Headers) -> bool:
        text = str(scope.get("query_string", b""), "ascii", "replace")
        query = dict(part.split("=", 1) for part in text.split("&") if "=" in part)
        if self._panel.admits(scope["path"], query.get("ticket", "")):
            return True
        kind, _, token = headers.get("authorization", "").partition(" ")
        if kind.casefold() != "bearer":
            token = _offered_token(headers) if scope["type"] == "websocket" else ""
        return hmac.compare_digest(token.encode(), self._panel.settings.token.encode())


def is_loopback(host: str) -> bool:
    """Return whether a host to listen on can be reached from this machine alone."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def check_public_name(name: str) -> None:
    """Raise UsageError for what is not a name of a host, with or without a port."""
    if _PUBLIC_NAME.fullmatch(name):
        return
    hint = "as a browser shows it between 'https://' and the next '/': rig.example.org"
    raise UsageError(f"'{name[:80]}' is not the name of a host", hint=hint)


def _with_port(netloc: str) -> str:
    name = netloc.casefold()
    return name if re.search(r":[0-9]+$", name) else f"{name}:443"


def _own_names(host: str) -> frozenset[str]:
    names = {"localhost", host.casefold()}
    if not is_loopback(host):
        names |= {socket.gethostname().casefold(), socket.getfqdn().casefold()}
    return frozenset(names)


def _split(address: str) -> SplitResult:
    """Return the parts of an address; of another text, parts that match none."""
    try:
        return urlsplit(address)
    except ValueError:
        return urlsplit("")


def _offered_token(headers: Headers) -> str:
    """Return the token among the subprotocols; empty without one."""
    protocols = map(str.strip, headers.get("sec-websocket-protocol", "").split(","))
    tokens = (protocol for protocol in protocols if protocol.startswith(_TOKEN_PROTOCOL))
    return next(tokens, "").removeprefix(_TOKEN_PROTOCOL)


async def _refuse(error: PanelError, scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "websocket":
        # ASGI requires that the connection is received before it is refused.
        await receive()
        await send({"type": "websocket.close", "code": 4000 + error.status, "reason": ""})
        return
    answer = JSONResponse(error.view.model_dump(mode="json"), error.status, HEADERS)
    await answer(scope, receive, send)
