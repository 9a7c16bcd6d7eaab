"""What no single field of a procedure can see: parts that do not fit together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import Problem
from rigrunner.procedure.walk import steps_of
from rigrunner.yamlfile.document import dotted

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.procedure.model import Procedure
    from rigrunner.yamlfile import Document
    from rigrunner.yamlfile.document import Path


def inconsistencies(procedure: Procedure, document: Document) -> list[Problem]:
    """Return every contradiction within a procedure, with its place."""
    return [
        Problem(message, document.where(path, key=document.part(path) is None), dotted(path), hint)
        for check in (_answers, _tries)
        for path, message, hint in check(procedure)
    ]


Complaint = tuple["Path", str, str]


def _answers(procedure: Procedure) -> Iterator[Complaint]:
    for path, step in steps_of(procedure):
        name = step.settings.answered()
        if name in procedure.inputs:
            message = f"the input '{name}' is asked at the start already"
            yield (*path, step.kind, "into"), message, "choose another name, or drop the input"


def _tries(procedure: Procedure) -> Iterator[Complaint]:
    for path, step in steps_of(procedure):
        retries = getattr(step.settings, "retries", 0)
        if retries and not getattr(step.settings, "repeatable", True):
            message = "the step is tried again, but is not repeatable"
            yield (*path, step.kind, "retries"), message, "leave one of them out"
