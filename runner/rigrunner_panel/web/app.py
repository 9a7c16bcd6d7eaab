"""The panel as an ASGI application."""

from __future__ import annotations

import asyncio
import logging
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from anyio import CapacityLimiter, to_thread
from pydantic import BaseModel, ValidationError
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Match, Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles

from rigrunner.api.errors import RigrunnerError
from rigrunner_panel.errors import ErrorView, PanelError, not_found, of_ours
from rigrunner_panel.web.asked import API, Asked
from rigrunner_panel.web.connections import REQUEST_S
from rigrunner_panel.web.hub import Hub
from rigrunner_panel.web.openapi import description
from rigrunner_panel.web.operations import OPERATIONS
from rigrunner_panel.web.security import CLIENT, Guard

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from starlette.requests import Request
    from starlette.types import ASGIApp, Receive, Scope, Send
    from starlette.websockets import WebSocket

    from rigrunner_panel.web.asked import Operation
    from rigrunner_panel.web.panel import Panel, Rig

STATIC = Path(__file__).parent.parent / "static"
URGENT_THREADS = 8
"""For Stop alone: it must not wait for requests that wait for a disk or a lock."""
LONGEST_QUERY = 1000
"""Characters of a value in the query; Python reads no number of more than 4300 digits."""
FILE_POLICY = (
    "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:; "
    "frame-ancestors 'self'"
)
"""A report is a page of its own, with styles and pictures inside; it can run and load nothing."""
_log = logging.getLogger("rigrunner_panel")


def make_app(panel: Panel) -> Starlette:
    """Return the application; while it is served, screens get what changes."""
    hub = Hub(panel)

    @asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        work = asyncio.create_task(hub.run())
        yield
        work.cancel()
        with suppress(asyncio.CancelledError):
            await work

    async def events(socket: WebSocket) -> None:
        client = socket.query_params.get("client", "")
        if not CLIENT.fullmatch(client):
            await socket.close(4400, "the query has no client id")
            return
        named = socket.query_params.get("rig", "")
        try:
            rig = await run_in_threadpool(panel.rig, named) if named else panel.only_rig()
        except PanelError as error:
            await socket.close(4000 + error.status, "there is no such station")
            return
        await hub.serve(socket, client, rig)

    known = [
        Route(f"{API}/openapi.json", _openapi, methods=["GET"]),
        *(_route(panel, each) for each in OPERATIONS),
    ]
    routes = [
        *known,
        WebSocketRoute(f"{API}/events", events),
        WebSocketRoute("/{path:path}", _no_such_socket),
        Mount("/api", _unknown(known)),
        Mount("/", StaticFiles(directory=STATIC, html=True)),
    ]
    return Starlette(
        routes=routes,
        middleware=[Middleware(Guard, panel=panel)],
        exception_handlers={
            PanelError: _panel_error,
            RigrunnerError: _our_error,
            HTTPException: _http_error,
            Exception: _bug,
        },
        lifespan=lifespan,
    )


def _route(panel: Panel, operation: Operation) -> Route:
    own_threads: list[CapacityLimiter] = []  # made where the event loop is known

    async def endpoint(request: Request) -> Response:
        named = request.query_params.get("rig", "")
        rig: Rig | None = None
        body = await _given(request, operation)
        if operation.of_rig:
            rig = await run_in_threadpool(_rig, panel, named, body)
        asked = _asked(request, panel, rig, operation, body)
        if operation.urgent and not own_threads:
            own_threads.append(CapacityLimiter(URGENT_THREADS))
        limiter = own_threads[0] if operation.urgent else None
        found = await to_thread.run_sync(operation.handler, rig or panel, asked, limiter=limiter)
        return _answer(found, operation.status)

    return Route(operation.path, endpoint, methods=[operation.method])


async def _given(request: Request, operation: Operation) -> BaseModel | None:
    """Return the body of a request that changes something; raise PanelError."""
    if operation.method != "POST":
        return None
    if not CLIENT.fullmatch(request.headers.get("x-rigrunner-client", "")):
        hint = "8 to 64 letters, digits, - and _, chosen at random by the client"
        raise PanelError(400, "bad_request", "X-Rigrunner-Client is missing or wrong", hint)
    return _parsed(await _body(request, operation.longest), operation.body)


def _rig(panel: Panel, named: str, body: BaseModel | None) -> Rig:
    """Return the rig that is meant, by the query, the body, or as the only one."""
    of_body = getattr(body, "station", "")
    if named and of_body and named != of_body:
        message = (
            f"got the rig '{named[:80]}' in the query and the station '{of_body[:80]}' in the body"
        )
        raise PanelError(400, "bad_request", message, "name the same one, or only one of them")
    rig = panel.rig(named or of_body) if named or of_body else panel.only_rig()
    if rig is None:
        hint = "GET /api/v1/rigs names them"
        raise PanelError(400, "bad_request", "name the rig: ?rig=...", hint)
    return rig


def _asked(
    request: Request,
    panel: Panel,
    rig: Rig | None,
    operation: Operation,
    body: BaseModel | None,
) -> Asked:
    client = request.headers.get("x-rigrunner-client", "")
    if operation.steers:
        by = panel.steering(client) if rig is None else rig.control.required(client)
    else:
        by = panel.name_of(client)
    query = dict(request.query_params)
    if any(len(text) > LONGEST_QUERY for text in query.values()):
        message = f"a value of the query is longer than {LONGEST_QUERY} characters"
        raise PanelError(400, "bad_request", message)
    return Asked(body, query, request.path_params, client, by)


async def _body(request: Request, longest: int) -> bytes:
    """Return the body; raise PanelError for one that is not JSON by its name, or too long."""
    kind = request.headers.get("content-type", "").partition(";")[0].strip().casefold()
    if kind != "application/json":
        raise PanelError(400, "bad_request", "the body must be application/json")
    content = bytearray()
    try:
        async with asyncio.timeout(REQUEST_S):
            async for chunk in request.stream():
                content += chunk
                if len(content) > longest:
                    raise PanelError(413, "too_long", f"the body is longer than {longest} bytes")
    except TimeoutError as error:
        message = f"the body did not come within {REQUEST_S:g} s"
        raise PanelError(408, "bad_request", message) from error
    return bytes(content)


def _parsed(content: bytes, model: type[BaseModel] | None) -> BaseModel | None:
    if model is None:
        return None
    try:
        return model.model_validate_json(content)
    except ValidationError as error:
        told = "; ".join(_words(each) for each in error.errors(include_url=False)[:10])
        hint = "GET /api/v1/openapi.json describes it"
        message = f"the body is invalid: {told}"
        raise PanelError(400, "bad_request", message, hint) from error


def _words(error: Any) -> str:
    where = ".".join(str(each) for each in error["loc"])
    return f"{where}: {error['msg']}" if where else str(error["msg"])


def _answer(found: BaseModel | str | Path, status: int) -> Response:
    """Return an answer, which may be JSON already, or a file."""
    if isinstance(found, Path):
        return FileResponse(found, headers={"Content-Security-Policy": FILE_POLICY})
    text = found if isinstance(found, str) else found.model_dump_json()
    return Response(text, status, media_type="application/json")


def _unknown(known: list[Route]) -> ASGIApp:
    """Return what answers a path that the API does not have, or not with that method."""

    async def refuse(scope: Scope, _: Receive, __: Send) -> None:
        whole = {**scope, "root_path": ""}
        fitting = [each for each in known if each.matches(whole)[0] is Match.PARTIAL]
        allowed = sorted(method for each in fitting for method in each.methods or ())
        if allowed:
            message = f"got {scope['method']}, expected {' or '.join(allowed)}"
            raise HTTPException(405, message, {"Allow": ", ".join(allowed)})
        hint = f"every path begins with {API}; GET {API}/openapi.json lists them"
        raise not_found(f"the API has no path '{scope['path'][:80]}'", hint)

    return refuse


async def _no_such_socket(socket: WebSocket) -> None:
    await socket.close(4404, f"the WebSocket is at {API}/events")


async def _openapi(_: Request) -> Response:
    return JSONResponse(description())


async def _panel_error(_: Request, error: Exception) -> Response:
    assert isinstance(error, PanelError)  # noqa: S101  (Starlette calls it for no other)
    return JSONResponse(error.view.model_dump(mode="json"), error.status)


async def _our_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, RigrunnerError)  # noqa: S101  (Starlette calls it for no other)
    return await _panel_error(request, of_ours(error))


async def _http_error(_: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)  # noqa: S101  (Starlette calls it for no other)
    code = "not_found" if error.status_code == 404 else "bad_request"  # noqa: PLR2004  (HTTP's own)
    view = ErrorView(code=code, message=str(error.detail))
    return JSONResponse(view.model_dump(mode="json"), error.status_code, error.headers)


async def _bug(_: Request, error: Exception) -> Response:
    _log.error("a bug in the panel", exc_info=error)
    message = f"{type(error).__name__}: {error}"
    view = ErrorView(code="bug", message=message, hint="the terminal of the panel shows where")
    return JSONResponse(view.model_dump(mode="json"), 500)
