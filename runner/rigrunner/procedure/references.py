"""`$name` stands for a parameter of the same file: plain replacement, no expressions."""

from __future__ import annotations

import difflib
import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import InvalidFileError, Problem
from rigrunner.yamlfile.document import dotted

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path

PARAMETERS = "parameters"
_NAME = re.compile(r"\$([A-Za-z][A-Za-z0-9_]*)")


def resolve(document: Document) -> Document:
    """Return the document with parameters in the place of references.

    The places stay those of the references, with the parameters as their origins. Raises
    InvalidFileError with every reference that leads nowhere.
    """
    if not isinstance(document.data, dict):
        return document
    found = document.data.get(PARAMETERS)
    parameters = found if isinstance(found, dict) else {}
    used = {path: text for path, text in _texts(document.data, ()) if text.startswith("$")}
    problems = [
        Problem(message, document.where(path), dotted(path), hint)
        for path, text in used.items()
        for message, hint in _complaints(path, text, parameters)
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


def _complaints(path: Path, text: str, known: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    match = _NAME.fullmatch(text)
    if match is None:
        yield f"'{text[:40]}' is not a reference", "write '$name'; there are no expressions"
    elif path[:1] == (PARAMETERS,):
        yield f"a parameter cannot refer to another, got '{text}'", "write the value"
    elif match[1] not in known:
        near = difflib.get_close_matches(match[1], known, n=1)
        meant = f"did you mean '${near[0]}'?" if near else ""
        names = ", ".join(f"${name}" for name in known) or "none"
        yield f"there is no parameter '{match[1]}'", meant or f"parameters: {names}"


def _replaced(node: Any, parameters: Mapping[str, Any]) -> Any:
    if isinstance(node, str):
        return parameters[node[1:]] if node.startswith("$") else node
    if isinstance(node, dict):
        return {key: _replaced(value, parameters) for key, value in node.items()}
    if isinstance(node, list):
        return [_replaced(value, parameters) for value in node]
    return node
