"""Find the keys that a model has at a place that a pydantic error names."""

from __future__ import annotations

from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, Tag


def known_keys(model_type: type[BaseModel], loc: tuple[int | str, ...]) -> tuple[str, ...]:
    """Return the keys of the model at `loc`, or none where there is no model."""
    current: Any = model_type
    for step in loc:
        current = _inside(current, step)
    models = [part for part in _alternatives(current) if _is_model(part)]
    return tuple(_fields(models[0])) if len(models) == 1 else ()


def _inside(annotation: Any, step: int | str) -> Any:
    alternatives = _alternatives(annotation)
    for part in alternatives:
        for mark in (part, *getattr(part, "__metadata__", ())):
            if hasattr(mark, "inside"):  # it knows the type under each key
                return mark.inside(step)
    for part in alternatives:
        # pydantic names an alternative of a union in a location: by its tag, or by its type
        tags = [tag.tag for tag in get_args(part)[1:] if isinstance(tag, Tag)]
        names = [*tags, getattr(unannotated(part), "__name__", "")]
        if len(alternatives) > 1 and step in names:
            return part
    for part in alternatives:
        if _is_model(part) and step in _fields(part):
            return _fields(part)[str(step)]
        if get_origin(part) in {list, tuple, dict}:
            return get_args(part)[1 if get_origin(part) is dict else 0]
    return None


def _alternatives(annotation: Any) -> list[Any]:
    bare = unannotated(annotation)
    if get_origin(bare) in {Union, UnionType}:
        return [part for part in get_args(bare) if part is not NoneType]
    return [annotation]


def unannotated(annotation: Any) -> Any:
    """Return the type in an annotation, without its metadata."""
    return get_args(annotation)[0] if get_origin(annotation) is Annotated else annotation


def _is_model(annotation: Any) -> bool:
    bare = unannotated(annotation)
    return isinstance(bare, type) and issubclass(bare, BaseModel)


def _fields(annotation: Any) -> dict[str, Any]:
    model: type[BaseModel] = unannotated(annotation)
    model.model_rebuild()  # one that holds itself, such as a sweep its steps, knows its fields then
    fields = model.model_fields
    return {field.alias or name: field.annotation for name, field in fields.items()}
