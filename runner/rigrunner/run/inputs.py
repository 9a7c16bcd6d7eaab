"""Inputs of a procedure: given, asked for, or its unattended answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, Problem, UsageError, did_you_mean
from rigrunner.procedure.answers import AnswerError
from rigrunner.steps.ask import question_of
from rigrunner.yamlfile import read

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping
    from pathlib import Path

    from rigrunner.engine import AnswerSource
    from rigrunner.procedure import Input, LoadedProcedure
    from rigrunner.yamlfile import Document

OPERATOR = "operator"
"""Name of the input for the operator, and of their role in the run."""


def answer_inputs(
    procedure: LoadedProcedure, given: Mapping[str, str], answers: AnswerSource
) -> dict[str, str]:
    """Return a value for every input of a procedure and of what it calls.

    Raises UsageError for a given value that is no input or not an accepted answer.
    """
    asked = procedure.inputs
    # First: questions are asked only after all given values were accepted.
    taken = {name: _accepted(procedure, name, given[name]) for name in given}
    return {
        name: taken.get(name)
        or each.expected.accept(answers.ask(f"inputs.{name}", question_of(name, each)))
        for name, each in asked.items()
    }


def with_operator(
    given: Mapping[str, str], operator: str | None, procedure: LoadedProcedure
) -> dict[str, str]:
    """Return the given inputs, with the operator where the procedure asks for one.

    Raises UsageError for an empty name and for two different operators.
    """
    if operator is None:
        return dict(given)
    if not operator.strip():
        raise UsageError("the operator has no name", hint="such as --operator 'A. Jones'")
    if given.get(OPERATOR, operator) != operator:
        both = f"'{given[OPERATOR]}' and '{operator}'"
        raise UsageError(f"two operators are given: {both}", hint="give one, by --operator")
    return {**given, OPERATOR: operator} if OPERATOR in procedure.inputs else dict(given)


def read_answers(path: Path, procedure: LoadedProcedure) -> dict[str, str]:
    """Return the answers in a file, a mapping of inputs to texts.

    Raises InvalidFileError with all problems.
    """
    document = read(path)
    problems = list(_problems(document, procedure.inputs))
    if problems:
        raise InvalidFileError(problems)
    return dict(document.data)


def _accepted(procedure: LoadedProcedure, name: str, answer: str) -> str:
    asked = procedure.inputs
    if name not in asked:
        message = f"{procedure.model.id} has no input '{name}'"
        raise UsageError(message, hint=_near(name, asked))
    try:
        return asked[name].expected.accept(answer)
    except AnswerError as error:
        raise UsageError(f"the input '{name}': {error.message}", hint=error.hint) from error


def _problems(document: Document, asked: Mapping[str, Input]) -> Iterator[Problem]:
    if not isinstance(document.data, dict):
        message, hint = "expected a mapping of inputs to answers", "such as 'specimen: SN-17'"
        yield Problem(message, document.where(()), hint=hint)
        return
    for name, answer in document.data.items():
        if name not in asked:
            where = document.where((name,), key=True)
            yield Problem("there is no such input", where, name, _near(name, asked))
            continue
        for message, hint in _objections(asked[name], answer):
            yield Problem(message, document.where((name,)), name, hint)


def _objections(wanted: Input, answer: object) -> Iterator[tuple[str, str]]:
    if not isinstance(answer, str) or not answer.strip():
        shown = str(answer) if str(answer or "").strip() else "nothing"
        in_unit = f"write it as '{shown} {wanted.unit}'" if wanted.unit else ""
        yield f"got {shown[:60]}, expected a text", in_unit or f"put it in quotes: '{shown[:60]}'"
        return
    try:
        wanted.expected.accept(answer)
    except AnswerError as error:
        yield error.message, error.hint


def _near(name: str, asked: Iterable[str]) -> str:
    names = list(asked)
    return did_you_mean(name, names, f"it asks for: {', '.join(names) or 'nothing'}")
