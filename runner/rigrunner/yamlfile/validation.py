"""Turn a document into a frozen model, or report every problem with its place."""

from __future__ import annotations

from dataclasses import replace
from itertools import groupby
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel, ValidationError

from rigrunner.api.errors import InvalidFileError, Problem
from rigrunner.yamlfile.document import dotted, has_part
from rigrunner.yamlfile.models import known_keys
from rigrunner.yamlfile.wording import ALLOWED, describe

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from pydantic_core import ErrorDetails

    from rigrunner.yamlfile.document import Document, Path

Model = TypeVar("Model", bound=BaseModel)
MAX_PROBLEMS = 50
MARK = "rigrunner"
"""The key that names the kind and form of a file, such as 'procedure/2'."""


def validate(
    model_type: type[Model],
    document: Document,
    at: Path = (),
    context: Mapping[str, Any] | None = None,
) -> Model:
    """Return the model of the document, or of its part at that path.

    An absent or empty part counts as an empty mapping. `context` is passed to the validators.
    Raises InvalidFileError with every problem: its place, the field, what was got and what is
    expected.
    """
    data = document.part(at)
    try:
        return model_type.model_validate({} if data is None else data, context=context)
    except ValidationError as error:
        errors = [
            details
            for details in error.errors(include_url=False)
            # A list is called too short also where items of it are wrong.
            if details["type"] != "too_short"
            or len(details["input"]) < details["ctx"]["min_length"]
        ]
        errors = _other_kind(errors) or errors
        problems = [_problem(model_type, document, at, each) for each in errors[:MAX_PROBLEMS]]
        if len(errors) > MAX_PROBLEMS:
            message = f"{len(errors) - MAX_PROBLEMS} more problems follow; fix these first"
            problems.append(Problem(message, document.where(at)))
        raise InvalidFileError(_merge(problems)) from error


def _merge(problems: Iterable[Problem]) -> Iterator[Problem]:
    """Yield one problem, not one for each alternative, where a value fits none of several kinds."""
    for _, group in groupby(problems, lambda problem: (problem.location, problem.field)):
        alike = list(group)
        parts = [problem.message.partition(ALLOWED) for problem in alike]
        if len(alike) > 1 and all(got == parts[0][0] and allowed for got, allowed, _ in parts):
            kinds = " or ".join(dict.fromkeys(kind for *_, kind in parts))
            yield replace(alike[0], message=f"{parts[0][0]}{ALLOWED}{kinds}")
        else:
            yield from alike


def _other_kind(errors: list[ErrorDetails]) -> list[ErrorDetails]:
    """Return the one error that reports a file of another or unknown kind, if there is one.

    An example is a station given as a procedure. Its other errors follow from that one.
    """
    for details in errors:
        if details["loc"] == (MARK,) and details["type"] == "missing":
            return [details]
        if details["loc"] == (MARK,) and details["type"] == "literal_error":
            allowed, got = details["ctx"]["expected"], str(details["input"])
            if "/" in got and got.partition("/")[0] != allowed.strip("'").partition("/")[0]:
                return [details]
    return []


def _problem(
    model_type: type[BaseModel], document: Document, at: Path, details: ErrorDetails
) -> Problem:
    kind, loc = details["type"], details["loc"]
    path = at + _path_in_file(document.part(at), loc, keep_last=kind == "missing")
    keys = known_keys(model_type, loc[:-1]) if kind == "extra_forbidden" else ()
    parents = [k for k in keys if loc[-1] in known_keys(model_type, (*loc[:-1], k))]
    message, hint = describe(details, keys, parents)
    if kind == "missing":
        where = document.where(path[:-1], key=True)
        return Problem(message, where, dotted(path), hint)
    if kind == "extra_forbidden" or loc[-1:] == ("[key]",):
        return Problem(message, document.where(path, key=True), dotted(path), hint)
    error = details.get("ctx", {}).get("error")
    path += getattr(error, "key", ())  # of a validator of the whole that knows the part
    column = getattr(error, "column", None)
    where = document.where(path) if column is None else document.within(path, column)
    origin = document.origin(path)
    hints = (hint, f"it is written at {origin}" if origin else "")
    return Problem(message, where, dotted(path), "; ".join(filter(None, hints)))


def _path_in_file(data: Any, loc: tuple[int | str, ...], *, keep_last: bool) -> Path:
    """Return the location without the parts that pydantic adds: tags of unions and '[key]'."""
    path: list[str | int] = []
    for index, step in enumerate(loc):
        if has_part(data, step):
            data = data[step]
            path.append(step)
        elif keep_last and index == len(loc) - 1:
            path.append(step)
    return tuple(path)
