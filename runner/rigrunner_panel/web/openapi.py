"""The OpenAPI 3.1 description of the API, from the table of operations and its models."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import msgspec
from pydantic.json_schema import models_json_schema

from rigrunner import __version__
from rigrunner.runfile.codec import KINDS
from rigrunner_panel.errors import ErrorView
from rigrunner_panel.web.operation import API
from rigrunner_panel.web.operations import OPERATIONS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from pydantic import BaseModel
    from pydantic.json_schema import JsonSchemaMode

    from rigrunner_panel.web.operation import Operation

_REF = "#/components/schemas/{model}"
_REF_NAME = "#/components/schemas/{name}"
Json = dict[str, Any]


def description() -> Json:
    """Return the description as JSON values."""
    refs, schemas = _schemas(OPERATIONS)
    schemas |= _message_schemas(schemas["State"])
    schemas["ToldEvent"]["properties"]["event"] = _ref("Event")
    paths: dict[str, Json] = {}
    for operation in OPERATIONS:
        paths.setdefault(operation.path, {})[operation.method.lower()] = _operation(operation, refs)
    _add_socket(paths[f"{API}/events"]["get"])
    response = {"description": "done", "content": _json({"type": "object"})}
    about = {"summary": "This description; without a token.", "operationId": "get_openapi_json"}
    paths[f"{API}/openapi.json"] = {"get": {**about, "responses": {"200": response}}}
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "Rigrunner panel",
            "version": __version__,
            "description": f"Runs test procedures. A WebSocket at {API}/events?client=ID tells "
            "what changes; files of a run have their addresses in the run.",
        },
        "components": {
            "schemas": schemas,
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
        },
        # Nothing, where the panel has no token, or the token.
        "security": [{}, {"token": []}],
        "paths": paths,
    }


def _schemas(operations: tuple[Operation, ...]) -> tuple[dict[type[BaseModel], Json], Json]:
    outgoing: JsonSchemaMode = "serialization"
    incoming: JsonSchemaMode = "validation"
    models: list[tuple[Any, JsonSchemaMode]] = [(ErrorView, outgoing)]
    models += [(op.answer, outgoing) for op in operations if op.answer is not None]
    models += [(op.body, incoming) for op in operations if op.body is not None]
    refs, schema = models_json_schema(list(dict.fromkeys(models)), ref_template=_REF)
    return {model: refs[model, mode] for model, mode in models}, schema["$defs"]


def _add_socket(events: Json) -> None:
    """Describe the WebSocket at the address of the events."""
    what = "with a WebSocket: the client's own id, as in X-Rigrunner-Client"
    client = {"name": "client", "in": "query", "description": what, "schema": {"type": "string"}}
    events["parameters"].append(client)
    frame = "application/octet-stream"
    events["responses"]["101"] = {
        "description": "the WebSocket; a text is a Message, a binary frame begins with the length "
        "of a FrameHeader (uint32, little-endian) and that header, then come its float32 arrays",
        "content": {**_json(_ref("Message")), frame: {"schema": _ref("FrameHeader")}},
    }


def _message_schemas(state: Json) -> Json:
    """Return the schemas of what a WebSocket sends."""
    refs, events = msgspec.json.schema_components(list(KINDS.values()), ref_template=_REF_NAME)
    text, number = {"type": "string"}, {"type": "integer"}
    changes = {"type": "object", "properties": state["properties"], "additionalProperties": False}
    messages = {
        "state": {"state": _ref("State")},
        "rigs": {"rigs": {"type": "array", "items": _ref("RigView")}},
        "delta": {"seq": number, "changes": changes},
        "event": {"version": number, "number": number, "text": text, "event": _ref("Event")},
    }
    value, flag = {"type": "number"}, {"type": "boolean"}
    array = {"prefixItems": [text, number], "minItems": 2, "maxItems": 2, "type": "array"}
    arrays = {"arrays": {"type": "array", "items": array, "description": "name and length"}}
    axis = _ref("Axis")
    frames = {
        "curve": {
            "recording": text,
            "title": text,
            "x": axis,
            "y": axis,
            "frequency_hz": {"type": ["number", "null"]},
            "t_s": value,
            "monotonic_s": value,
            "late_s": value,
        },
        "trend": {"first": number, "step_s": value, "reset": flag, "channel": text, "unit": text},
    }
    headers = [_tagged("kind", kind, {**fields, **arrays}) for kind, fields in frames.items()]
    return {
        **events,
        "Event": {"oneOf": list(refs)},
        "Message": {"oneOf": [_tagged("type", kind, fields) for kind, fields in messages.items()]},
        "FrameHeader": {"oneOf": headers},
    }


def _tagged(tag: str, kind: str, fields: Json) -> Json:
    """Return the schema of an object with these fields and a tag for its kind."""
    properties = {tag: {"const": kind}, **fields}
    return {"type": "object", "required": list(properties), "properties": properties}


def _ref(name: str) -> Json:
    return {"$ref": _REF_NAME.format(name=name)}


def _operation(operation: Operation, refs: dict[type[BaseModel], Json]) -> Json:
    words = (operation.method.lower(), *re.findall(r"\w+", operation.path.removeprefix(API)))
    content = {"*/*": {}} if operation.answer is None else _json(refs[operation.answer])
    entry: Json = {
        "summary": operation.summary,
        "operationId": "_".join(words).replace("-", "_"),
        "parameters": list(_parameters(operation)),
        "responses": {
            str(operation.status): {"description": "done", "content": content},
            "default": {"description": "an error", "content": _json(refs[ErrorView])},
        },
    }
    if operation.body is not None:
        entry["requestBody"] = {"required": True, "content": _json(refs[operation.body])}
    return entry


def _parameters(operation: Operation) -> Iterator[Json]:
    text = {"type": "string"}
    for name in re.findall(r"{(\w+)}", operation.path):
        yield {"name": name, "in": "path", "required": True, "schema": text}
    for name, what in operation.query.items():
        yield {"name": name, "in": "query", "description": what, "schema": text}
    if operation.method == "POST":
        what = "the client's own id, 8 to 64 letters, digits, - and _"
        meaning = f"{what}; it must have control" if operation.steers else what
        yield {
            "name": "X-Rigrunner-Client",
            "in": "header",
            "required": True,
            "description": meaning,
            "schema": text,
        }


def _json(schema: Json) -> Json:
    return {"application/json": {"schema": schema}}
