"""Describe each field of a settings model: kind, units, bounds, default and help."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections import abc
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel, WithJsonSchema
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from rigrunner.api.quantity import readable
from rigrunner.api.settings import QuantitySchema
from rigrunner.api.units import units_of
from rigrunner.yamlfile.models import unannotated

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

_KINDS = {
    "bool": "true | false",
    "int": "whole number",
    "float": "number",
    "str": "text",
    "Any": "anything",
    "Quantity": "quantity",
}
_ENTRIES: dict[Any, tuple[int, str, str]] = {
    tuple: (0, "[]", "list of"),
    dict: (1, ".NAME", "mapping of names to"),
    abc.Mapping: (1, ".NAME", "mapping of names to"),
}
"""Of lists and mappings: the position of an entry's type, the form of its name, and a word."""
_JSON_KINDS = {"string": "text", "number": "number", "boolean": "yes or no"}
_BOUNDS = (
    (Gt, "gt", "more than"),
    (Ge, "ge", "at least"),
    (Lt, "lt", "less than"),
    (Le, "le", "at most"),
)


@dataclass(frozen=True)
class Field:
    """One key of a model."""

    key: str
    kind: str
    """The kind of value: 'length', 'whole number', 'slip speed', ..."""
    units: tuple[str, ...]
    """The units that a quantity may have."""
    bounds: str
    """Bounds, such as 'more than 0 %, at most 5 %'."""
    default: Any
    """The default as written in YAML; None where there is none to write."""
    required: bool
    help: str
    model: type[BaseModel] | None
    """The model of the value, or of the entries of a list or a mapping; else None."""
    entry: str
    """The form of an entry's name in that list or mapping: '[]' or '.NAME'."""


def fields_of(model: type[BaseModel]) -> Iterator[Field]:
    """Yield the fields of the model, in order."""
    docstrings = docstrings_of(model)
    for name, info in model.model_fields.items():
        annotation: Any = info.annotation
        if info.metadata:
            annotation = Annotated[info.annotation, *info.metadata]
        quantity = _quantity(annotation)
        dimension = None if quantity is None else quantity.dimension
        inner = _without_none(annotation)
        inside, entry = _model(inner)
        yield Field(
            key=info.alias or name,
            kind=_kind(inner),
            units=tuple(units_of(dimension)) if dimension else (),
            bounds=_bounds(annotation, dimension),
            default=_yaml_value(None if info.is_required() else info.get_default(), dimension),
            required=info.is_required(),
            help=info.description or docstrings.get(name, ""),
            model=inside,
            entry=entry,
        )


def docstrings_of(model: type[BaseModel]) -> dict[str, str]:
    """Return the docstrings under the fields of the model, if the source is available."""
    docstrings: dict[str, str] = {}
    for base in reversed(model.__mro__):
        if issubclass(base, BaseModel) and base is not BaseModel:
            docstrings |= _own_docstrings(base)
    return docstrings


def all_fields(model: type[BaseModel], prefix: str = "") -> Iterator[tuple[str, Field]]:
    """Yield the fields of the model and of the models in it, with their names.

    Examples are `sensors.rate`, `channels.NAME.unit` in a mapping of models, `points[].x` in a
    list.
    """
    for field in fields_of(model):
        if field.model is None or field.help:
            yield f"{prefix}{field.key}", field
        if field.model is not None:
            yield from all_fields(field.model, f"{prefix}{field.key}{field.entry}.")


def _marks(annotation: Any) -> Iterator[Any]:
    """Yield the metadata of a type in Annotated, at any depth."""
    if get_origin(annotation) is Annotated:
        for mark in get_args(annotation)[1:]:
            yield from mark.metadata if isinstance(mark, FieldInfo) else (mark,)
        yield from _marks(get_args(annotation)[0])
    else:
        for part in get_args(annotation):
            yield from _marks(part)


def _quantity(annotation: Any) -> QuantitySchema | None:
    """Return the quantity in an annotation, or None."""
    return next((mark for mark in _marks(annotation) if isinstance(mark, QuantitySchema)), None)


def _without_none(annotation: Any) -> Any:
    bare = unannotated(annotation)
    if get_origin(bare) in {Union, UnionType}:
        members = [part for part in get_args(bare) if part is not NoneType]
        return members[0] if len(members) == 1 else bare
    return annotation


def _model(annotation: Any) -> tuple[type[BaseModel] | None, str]:
    bare = unannotated(annotation)
    if get_origin(bare) in _ENTRIES:
        place, entry, _ = _ENTRIES[get_origin(bare)]
        return _model(get_args(bare)[place])[0], entry
    is_model = isinstance(bare, type) and issubclass(bare, BaseModel)
    return (bare, "") if is_model else (None, "")


def _kind(annotation: Any) -> str:
    bare = unannotated(annotation)
    origin, parts = get_origin(bare), get_args(bare)
    if origin in _ENTRIES:
        place, _, words = _ENTRIES[origin]
        return f"{words} {_kind(parts[place])}"
    if origin in {Union, UnionType}:
        return " or ".join(_kind(part) for part in parts if part is not NoneType)
    if origin is Literal:
        return " | ".join(text if text[:1].isalnum() else f'"{text}"' for text in map(str, parts))
    if isinstance(bare, type) and issubclass(bare, BaseModel):
        return "settings"
    quantity = _quantity(annotation)
    if quantity is not None:
        return quantity.dimension or "quantity"
    schemas = (mark for mark in _marks(annotation) if isinstance(mark, WithJsonSchema))
    mark = next(schemas, None)
    kind = "" if mark is None else _kind_of_schema(mark.json_schema or {})
    name = getattr(bare, "__name__", "value")
    return kind or _KINDS.get(name, name)


def _kind_of_schema(schema: Mapping[str, Any]) -> str:
    """Return what a JSON schema of a scalar accepts, as text; '' for any other schema."""
    if True in schema.get("enum", ()):
        return "yes | no"
    kinds: list[str] = []
    for option in schema.get("anyOf", [schema]):
        kind = option.get("type", [])
        kinds += [kind] if isinstance(kind, str) else kind
    return " or ".join(_JSON_KINDS[kind] for kind in kinds if kind in _JSON_KINDS)


def _bounds(annotation: Any, dimension: str | None) -> str:
    marks = list(_marks(annotation))
    bounds = (
        (words, getattr(mark, attribute))
        for kind, attribute, words in _BOUNDS
        for mark in marks
        if isinstance(mark, kind)
    )
    return ", ".join(  # 0 needs no unit
        f"{words} {0 if value == 0 else _yaml_value(value, dimension)}" for words, value in bounds
    )


def _yaml_value(value: Any, dimension: str | None) -> Any:
    """Return a value as written in YAML: a quantity with its unit, a list, a plain value."""
    if isinstance(value, BaseModel) or value in (None, "", (), {}, PydanticUndefined):
        return None
    if isinstance(value, tuple):
        return [_yaml_value(item, dimension) for item in value]
    if dimension is not None and isinstance(value, (int, float)):
        return str(readable(float(value), dimension))
    return value


@lru_cache(maxsize=512)  # a schema needs most models many times, and their source is parsed
def _own_docstrings(model: type[BaseModel]) -> Mapping[str, str]:
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(model)))
    except (OSError, TypeError, SyntaxError):
        return {}
    (body,) = (node.body for node in tree.body if isinstance(node, ast.ClassDef))
    return {
        field.target.id: inspect.cleandoc(text.value.value)
        for field, text in pairwise(body)
        if isinstance(field, ast.AnnAssign)
        and isinstance(field.target, ast.Name)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
        and isinstance(text.value.value, str)
    }
