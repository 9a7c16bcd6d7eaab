"""From a file, or a stored text, to a procedure."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError
from rigrunner.procedure.consistency import inconsistencies
from rigrunner.procedure.model import Procedure
from rigrunner.procedure.references import resolve
from rigrunner.yamlfile import parse, validate
from rigrunner.yamlfile.reader import read_text

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner.yamlfile import Document


@dataclass(frozen=True, eq=False)
class LoadedProcedure:
    """A procedure, where each part of it stands, and the text that it was read from."""

    model: Procedure
    document: Document
    """With references replaced."""
    digest: str
    """SHA-256 of the text in UTF-8, hexadecimal."""
    text: str


def load_procedure(path: Path) -> LoadedProcedure:
    """Return the procedure in that file; raise InvalidFileError with all that is wrong in it."""
    return parse_procedure(read_text(path), str(path))


def parse_procedure(text: str, name: str) -> LoadedProcedure:
    """Return the procedure in a text; `name` stands for the file in messages.

    Raises InvalidFileError with all that is wrong.
    """
    document = resolve(parse(text, name))
    model = validate(Procedure, document)
    problems = inconsistencies(model, document)
    if problems:
        raise InvalidFileError(problems)
    return LoadedProcedure(model, document, hashlib.sha256(text.encode()).hexdigest(), text)
