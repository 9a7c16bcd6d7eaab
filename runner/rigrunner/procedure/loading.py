"""From a file, or a stored text, to a procedure."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, Problem
from rigrunner.procedure.kinds import ASKED, KINDS, STORED
from rigrunner.procedure.model import Procedure
from rigrunner.procedure.references import resolve, with_values
from rigrunner.procedure.walk import steps_of
from rigrunner.yamlfile import parse, validate
from rigrunner.yamlfile.document import dotted
from rigrunner.yamlfile.upgrade import refuse_older, upgraded

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rigrunner.procedure.kinds import Kinds
    from rigrunner.procedure.questions import Input
    from rigrunner.procedure.references import Values
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path as DocumentPath


@dataclass(frozen=True, eq=False)
class LoadedProcedure:
    """A procedure, where each part of it stands, and the text that it was read from."""

    model: Procedure
    document: Document
    """With references replaced."""
    digest: str
    """SHA-256 of the text in UTF-8, hexadecimal."""
    text: str
    called: Mapping[DocumentPath, LoadedProcedure] = field(default_factory=dict)
    """The procedures that it calls, by the place of the step, such as ('main', 0)."""

    @property
    def folder(self) -> Path:
        """Where the files are that it names."""
        return Path(self.document.name).parent

    @property
    def inputs(self) -> dict[str, Input]:
        """All that is asked at the start: by what it calls, and by itself, which comes first."""
        inputs = dict(self.model.inputs)
        for called in self.all_called():
            inputs = {**called.model.inputs, **inputs}
        return inputs

    @property
    def called_texts(self) -> dict[str, str]:
        """The text of each procedure that is called, by its path from the folder of this one."""
        return {
            Path(called.document.name).relative_to(self.folder).as_posix(): called.text
            for called in self.all_called()
        }

    @property
    def digest_with_called(self) -> str:
        """SHA-256 over this text and all that is called: what an approval is bound to."""
        return texts_digest(self.text, self.called_texts)

    def all_called(self) -> Iterator[LoadedProcedure]:
        """Yield the procedures that it calls, and that these call."""
        for called in self.called.values():
            yield called
            yield from called.all_called()


class InconsistentProcedureError(InvalidFileError):
    """A procedure whose parts contradict each other, but can be read: `loaded`."""

    def __init__(self, problems: Iterable[Problem], loaded: LoadedProcedure) -> None:
        super().__init__(problems)
        self.loaded = loaded


def parse_procedure(
    text: str,
    name: str,
    values: Values | None = None,
    kinds: Kinds | None = None,
    *,
    stored: bool = False,
) -> LoadedProcedure:
    """Return the procedure in a text; `name` stands for the file in messages.

    `kinds` are the kinds of steps and the analyses that it may name; left out, the installed ones.
    `stored`: of a run that was done, whose plugins may be missing here; it may be in an older form
    of the language. What it calls is not looked up. Raises InvalidFileError with all that is wrong.
    """
    parsed = parse(upgraded(text, name) if stored else text, name)
    refuse_older(parsed)
    document = resolve(with_values(parsed, values or {}))
    # The names of the analyses, as far as they are written as they should be.
    part = document.part(("analysis",))
    entries = part if isinstance(part, list) else []
    analyses = [str(name) for entry in entries if isinstance(entry, dict) for name in entry]
    context = {KINDS: kinds, STORED: stored, ASKED: analyses}
    model = validate(Procedure, document, context=context)
    # Of the text as it stands, upgraded or not: approvals and documents name it by this.
    digest = _sha256(text)
    loaded = LoadedProcedure(model, document, digest, text)
    problems = inconsistencies(model, document)
    if problems:
        raise InconsistentProcedureError(problems, loaded)
    return loaded


def texts_digest(text: str, called: Mapping[str, str]) -> str:
    """Return a SHA-256, hexadecimal, over a procedure's text and those that it calls, by path.

    An approval is bound to it. It is the digest of a list as `sha256sum` prints it: a line for the
    procedure, then one for each called file, sorted by path; each line is the SHA-256 of a text in
    UTF-8, two spaces and a name.
    """
    # Not the name of the procedure's own file, which may be renamed.
    names = [("procedure", text), *sorted(called.items())]
    return _sha256("".join(f"{_sha256(content)}  {name}\n" for name, content in names))


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def inconsistencies(procedure: Procedure, document: Document) -> list[Problem]:
    """Return every contradiction within a procedure, with its place."""
    return [
        Problem(message, document.where(path, key=document.part(path) is None), dotted(path), hint)
        for check in (_answers, _tries)
        for path, message, hint in check(procedure)
    ]


Complaint = tuple["DocumentPath", str, str]


def _answers(procedure: Procedure) -> Iterator[Complaint]:
    for path, step in steps_of(procedure):
        name = step.settings.answered()
        if name in procedure.inputs:
            message = f"the input '{name}' is already asked at the start"
            yield (*path, step.kind, "into"), message, "choose another name, or drop the input"


def _tries(procedure: Procedure) -> Iterator[Complaint]:
    for path, step in steps_of(procedure):
        retries = getattr(step.settings, "retries", 0)
        if retries and not getattr(step.settings, "repeatable", True):
            message = "the step has retries, but is not repeatable"
            yield (*path, step.kind, "retries"), message, "leave one of them out"
