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
    procedure: LoadedProcedure, inputs: Mapping[str, str], answers: AnswerSource
) -> dict[str, str]:
    """Return a value for every input of a procedure and of what it calls.

    Raises UsageError for a given value that is no input or not an accepted answer.
    """
    definitions = procedure.inputs
    # First: questions are asked only after all given values were accepted.
    accepted = {name: _accepted(procedure, name, inputs[name]) for name in inputs}
    return {
        name: accepted.get(name)
        or definition.expected.accept(answers.ask(f"inputs.{name}", question_of(name, definition)))
        for name, definition in definitions.items()
    }


def with_operator(
    inputs: Mapping[str, str], operator: str | None, procedure: LoadedProcedure
) -> dict[str, str]:
    """Return the given inputs, with the operator where the procedure asks for one.

    Raises UsageError for an empty name and for two different operators.
    """
    if operator is None:
        return dict(inputs)
    if not operator.strip():
        raise UsageError("the operator has no name", hint="such as --operator 'A. Jones'")
    if inputs.get(OPERATOR, operator) != operator:
        names = f"'{inputs[OPERATOR]}' and '{operator}'"
        raise UsageError(f"two operators are given: {names}", hint="give one, by --operator")
    return {**inputs, OPERATOR: operator} if OPERATOR in procedure.inputs else dict(inputs)


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
    definitions = procedure.inputs
    if name not in definitions:
        message = f"{procedure.model.id} has no input '{name}'"
        raise UsageError(message, hint=_suggestion(name, definitions))
    try:
        return definitions[name].expected.accept(answer)
    except AnswerError as error:
        raise UsageError(f"the input '{name}': {error.message}", hint=error.hint) from error


def _problems(document: Document, definitions: Mapping[str, Input]) -> Iterator[Problem]:
    if not isinstance(document.data, dict):
        message, hint = "expected a mapping of inputs to answers", "such as 'specimen: SN-17'"
        yield Problem(message, document.where(()), hint=hint)
        return
    for name, answer in document.data.items():
        if name not in definitions:
            where = document.where((name,), key=True)
            yield Problem("there is no such input", where, name, _suggestion(name, definitions))
            continue
        for message, hint in _objections(definitions[name], answer):
            yield Problem(message, document.where((name,)), name, hint)


def _objections(definition: Input, answer: object) -> Iterator[tuple[str, str]]:
    if not isinstance(answer, str) or not answer.strip():
        text = str(answer) if str(answer or "").strip() else "nothing"
        hint = f"write it as '{text} {definition.unit}'" if definition.unit else ""
        yield f"got {text[:60]}, expected a text", hint or f"put it in quotes: '{text[:60]}'"
        return
    try:
        definition.expected.accept(answer)
    except AnswerError as error:
        yield error.message, error.hint


def _suggestion(name: str, inputs: Iterable[str]) -> str:
    names = list(inputs)
    return did_you_mean(name, names, f"it asks for: {', '.join(names) or 'nothing'}")
