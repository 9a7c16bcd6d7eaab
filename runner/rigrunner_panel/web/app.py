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
from rigrunner_panel.errors import ErrorView, PanelError, not_found, panel_error
from rigrunner_panel.web.connections import REQUEST_S
from rigrunner_panel.web.hub import Hub
from rigrunner_panel.web.openapi import description
from rigrunner_panel.web.operation import API, ApiRequest
from rigrunner_panel.web.operations import OPERATIONS
from rigrunner_panel.web.security import CLIENT, Guard

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from starlette.requests import Request
    from starlette.types import ASGIApp, Receive, Scope, Send
    from starlette.websockets import WebSocket

    from rigrunner_panel.web.operation import Operation
    from rigrunner_panel.web.panel import Panel, Rig

STATIC = Path(__file__).parent.parent / "static"
URGENT_THREADS = 8
"""For Stop only: it must not wait for requests that wait for a disk or a lock."""
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
        name = socket.query_params.get("rig", "")
        try:
            rig = await run_in_threadpool(panel.rig, name) if name else panel.only_rig()
        except PanelError as error:
            await socket.close(4000 + error.status, "there is no such station")
            return
        await hub.serve(socket, client, rig)

    api_routes = [
        Route(f"{API}/openapi.json", _openapi, methods=["GET"]),
        *(_route(panel, operation) for operation in OPERATIONS),
    ]
    routes = [
        *api_routes,
        WebSocketRoute(f"{API}/events", events),
        WebSocketRoute("/{path:path}", _no_such_socket),
        Mount("/api", _unknown(api_routes)),
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
    own_threads: list[CapacityLimiter] = []  # created in the event loop

    async def endpoint(request: Request) -> Response:
        name = request.query_params.get("rig", "")
        rig: Rig | None = None
        body = await _read_body(request, operation)
        if operation.of_rig:
            rig = await run_in_threadpool(_rig, panel, name, body)
        api_request = _api_request(request, panel, rig, operation, body)
        if operation.urgent and not own_threads:
            own_threads.append(CapacityLimiter(URGENT_THREADS))
        limiter = own_threads[0] if operation.urgent else None
        handler, target = operation.handler, rig or panel
        content = await to_thread.run_sync(handler, target, api_request, limiter=limiter)
        return _answer(content, operation.status)

    return Route(operation.path, endpoint, methods=[operation.method])


async def _read_body(request: Request, operation: Operation) -> BaseModel | None:
    """Return the body of a request that changes something; raise PanelError."""
    if operation.method != "POST":
        return None
    if not CLIENT.fullmatch(request.headers.get("x-rigrunner-client", "")):
        hint = "8 to 64 letters, digits, - and _, chosen at random by the client"
        raise PanelError(400, "bad_request", "X-Rigrunner-Client is missing or wrong", hint)
    return _parse(await _content(request, operation.longest), operation.body)


def _rig(panel: Panel, name: str, body: BaseModel | None) -> Rig:
    """Return the rig that the query or the body names, or else the only one."""
    station = getattr(body, "station", "")
    if name and station and name != station:
        message = (
            f"got the rig '{name[:80]}' in the query and the station '{station[:80]}' in the body"
        )
        raise PanelError(400, "bad_request", message, "name the same one, or only one of them")
    rig = panel.rig(name or station) if name or station else panel.only_rig()
    if rig is None:
        hint = "GET /api/v1/rigs names them"
        raise PanelError(400, "bad_request", "name the rig: ?rig=...", hint)
    return rig


def _api_request(
    request: Request,
    panel: Panel,
    rig: Rig | None,
    operation: Operation,
    body: BaseModel | None,
) -> ApiRequest:
    client = request.headers.get("x-rigrunner-client", "")
    if operation.steers:
        by = panel.steering_name(client) if rig is None else rig.control.require(client)
    else:
        by = panel.name_of(client)
    query = dict(request.query_params)
    if any(len(text) > LONGEST_QUERY for text in query.values()):
        message = f"a value of the query is longer than {LONGEST_QUERY} characters"
        raise PanelError(400, "bad_request", message)
    return ApiRequest(body, query, request.path_params, client, by)


async def _content(request: Request, longest: int) -> bytes:
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


def _parse(content: bytes, model: type[BaseModel] | None) -> BaseModel | None:
    if model is None:
        return None
    try:
        return model.model_validate_json(content)
    except ValidationError as error:
        problems = "; ".join(_words(problem) for problem in error.errors(include_url=False)[:10])
        hint = "GET /api/v1/openapi.json describes it"
        message = f"the body is invalid: {problems}"
        raise PanelError(400, "bad_request", message, hint) from error


def _words(error: Any) -> str:
    where = ".".join(str(part) for part in error["loc"])
    return f"{where}: {error['msg']}" if where else str(error["msg"])


def _answer(content: BaseModel | str | Path, status: int) -> Response:
    """Return a response with a model, JSON text or a file."""
    if isinstance(content, Path):
        return FileResponse(content, headers={"Content-Security-Policy": FILE_POLICY})
    text = content if isinstance(content, str) else content.model_dump_json()
    return Response(text, status, media_type="application/json")


def _unknown(routes: list[Route]) -> ASGIApp:
    """Return an app that refuses a path or method that the API does not have."""

    async def refuse(scope: Scope, _: Receive, __: Send) -> None:
        full_scope = {**scope, "root_path": ""}
        partial = [route for route in routes if route.matches(full_scope)[0] is Match.PARTIAL]
        allowed = sorted(method for route in partial for method in route.methods or ())
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
    return await _panel_error(request, panel_error(error))


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
