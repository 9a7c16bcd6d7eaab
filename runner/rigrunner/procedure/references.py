"""`$name` stands for a parameter of the same file: plain replacement, no expressions.

A text that begins with `$$` is meant as it stands, with one `$`.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import InvalidFileError, Problem
from rigrunner.yamlfile.document import Document, Path, dotted

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator

PARAMETERS = "parameters"
_NAME = re.compile(r"\$([A-Za-z][A-Za-z0-9_]*)")
_ESCAPE = "$$"

Given = Mapping[str, tuple[Document, Path]]
"""Values for parameters, by name: each a document and where it stands there."""


def with_given(document: Document, given: Given) -> Document:
    """Return the document with given values in the place of its own parameters'.

    Raises InvalidFileError with every value for a parameter that the document does not have.
    """
    known = document.part((PARAMETERS,)) or {}
    unknown = {name: place for name, place in given.items() if name not in known}
    if unknown:
        raise InvalidFileError(
            Problem(
                f"{document.name} has no parameter '{name}'",
                other.where(at, key=True),
                dotted(at),
                _near(name, known, mark=""),
            )
            for name, (other, at) in unknown.items()
        )
    values = {name: other.part(at) for name, (other, at) in given.items()}
    data = {**document.data, PARAMETERS: {**known, **values}} if given else document.data
    return replace(document, data=data, given={(PARAMETERS, n): p for n, p in given.items()})


def resolve(document: Document) -> Document:
    """Return the document with parameters in the place of references.

    The places stay those of the references, with the parameters as their origins. Raises
    InvalidFileError with every reference that leads nowhere.
    """
    if not isinstance(document.data, dict):
        return document
    found = document.data.get(PARAMETERS)
    parameters = found if isinstance(found, dict) else {}
    texts = dict(_texts(document.data, ()))
    used = {path: text for path, text in texts.items() if _is_reference(text)}
    counters = {text for path, text in texts.items() if path[-2:] == ("repeat", "as")}
    problems = [
        Problem(message, document.where(path), dotted(path), hint)
        for path, text in used.items()
        for message, hint in _complaints(path, text, parameters, counters)
    ]
    if problems:
        raise InvalidFileError(problems)
    data = _replaced(document.data, parameters)
    return replace(document, data=data, origins={p: (PARAMETERS, t[1:]) for p, t in used.items()})


def _texts(node: Any, path: Path) -> Iterator[tuple[Path, str]]:
    if isinstance(node, str):
        yield path, node
    elif isinstance(node, dict):
        for key, value in node.items():
            yield from _texts(value, (*path, key))
    elif isinstance(node, list):
        for index, value in enumerate(node):
            yield from _texts(value, (*path, index))


def _complaints(
    path: Path, text: str, known: Mapping[str, Any], counters: Collection[str]
) -> Iterator[tuple[str, str]]:
    match = _NAME.fullmatch(text)
    if match is None:
        hint = f"write '$name'; there are no expressions; for the text itself write '${text[:40]}'"
        yield f"'{text[:40]}' is not a reference", hint
    elif path[:1] == (PARAMETERS,):
        yield f"a parameter cannot refer to another, got '{text}'", "write the value"
    elif match[1] in counters and match[1] not in known:
        hint = "its value cannot be used in a step: write a sweep over a list of values"
        yield f"'{match[1]}' counts a repeat and is not a parameter", hint
    elif match[1] not in known:
        yield f"there is no parameter '{match[1]}'", _near(match[1], known, mark="$")


def _near(name: str, known: Iterable[str], mark: str) -> str:
    names = list(known)
    near = difflib.get_close_matches(name, names, n=1)
    listing = ", ".join(f"{mark}{each}" for each in names) or "none"
    return f"did you mean '{mark}{near[0]}'?" if near else f"parameters: {listing}"


def _is_reference(text: str) -> bool:
    return text.startswith("$") and not text.startswith(_ESCAPE)


def _replaced(node: Any, parameters: Mapping[str, Any]) -> Any:
    if isinstance(node, str):
        if _is_reference(node):
            # With no parameters: a value that refers to another one was refused, and `$$` is left.
            return _replaced(parameters[node[1:]], {})
        return node.removeprefix("$") if node.startswith(_ESCAPE) else node
    if isinstance(node, dict):
        return {key: _replaced(value, parameters) for key, value in node.items()}
    if isinstance(node, list):
        return [_replaced(value, parameters) for value in node]
    return node
