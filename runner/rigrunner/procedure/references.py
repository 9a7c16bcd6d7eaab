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

Values = Mapping[str, tuple[Document, Path]]
"""Values for parameters, by name: each a document and where it stands there."""


def with_values(document: Document, values: Values) -> Document:
    """Return the document with values in the place of its own parameters'.

    Raises InvalidFileError with every value for a parameter that the document does not have.
    """
    parameters = document.part((PARAMETERS,)) or {}
    extra = {name: place for name, place in values.items() if name not in parameters}
    if extra:
        raise InvalidFileError(
            Problem(
                f"{document.name} has no parameter '{name}'",
                source.where(at, key=True),
                dotted(at),
                _near(name, parameters, mark=""),
            )
            for name, (source, at) in extra.items()
        )
    replaced = {name: source.part(at) for name, (source, at) in values.items()}
    data = {**document.data, PARAMETERS: {**parameters, **replaced}} if values else document.data
    return replace(document, data=data, given={(PARAMETERS, n): at for n, at in values.items()})


def resolve(document: Document) -> Document:
    """Return the document with parameters in the place of references.

    The places stay those of the references, with the parameters as their origins. Raises
    InvalidFileError with every reference that leads nowhere.
    """
    if not isinstance(document.data, dict):
        return document
    section = document.data.get(PARAMETERS)
    parameters = section if isinstance(section, dict) else {}
    texts = dict(_texts(document.data, ()))
    references = {path: text for path, text in texts.items() if _is_reference(text)}
    counters = {text for path, text in texts.items() if path[-2:] == ("repeat", "as")}
    problems = [
        Problem(message, document.where(path), dotted(path), hint)
        for path, text in references.items()
        for message, hint in _complaints(path, text, parameters, counters)
    ]
    if problems:
        raise InvalidFileError(problems)
    data = _resolved(document.data, parameters)
    origins = {path: (PARAMETERS, text[1:]) for path, text in references.items()}
    return replace(document, data=data, origins=origins)


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
    path: Path, text: str, parameters: Mapping[str, Any], counters: Collection[str]
) -> Iterator[tuple[str, str]]:
    match = _NAME.fullmatch(text)
    if match is None:
        hint = f"write '$name'; there are no expressions; for the text itself write '${text[:40]}'"
        yield f"'{text[:40]}' is not a reference", hint
    elif path[:1] == (PARAMETERS,):
        yield f"a parameter cannot refer to another, got '{text}'", "write the value"
    elif match[1] in counters and match[1] not in parameters:
        hint = "its value cannot be used in a step: write a sweep over a list of values"
        yield f"'{match[1]}' counts a repeat and is not a parameter", hint
    elif match[1] not in parameters:
        yield f"there is no parameter '{match[1]}'", _near(match[1], parameters, mark="$")


def _near(name: str, parameters: Iterable[str], mark: str) -> str:
    names = list(parameters)
    near = difflib.get_close_matches(name, names, n=1)
    listing = ", ".join(f"{mark}{name}" for name in names) or "none"
    return f"did you mean '{mark}{near[0]}'?" if near else f"parameters: {listing}"


def _is_reference(text: str) -> bool:
    return text.startswith("$") and not text.startswith(_ESCAPE)


def _resolved(node: Any, parameters: Mapping[str, Any]) -> Any:
    if isinstance(node, str):
        if _is_reference(node):
            # With no parameters: a value that refers to another one was refused, and `$$` is left.
            return _resolved(parameters[node[1:]], {})
        return node.removeprefix("$") if node.startswith(_ESCAPE) else node
    if isinstance(node, dict):
        return {key: _resolved(value, parameters) for key, value in node.items()}
    if isinstance(node, list):
        return [_resolved(value, parameters) for value in node]
    return node
