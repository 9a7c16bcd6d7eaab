"""Lists of specimens: scanned or pasted lines, and CSV files."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, Location, Problem, UsageError
from rigrunner.procedure.answers import AnswerError
from rigrunner.queue.entries import SPECIMEN

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.procedure import Input

MOST_LINES = 1000
LONGEST_LINE = 2000
DELIMITERS = ("\t", ";", ",")


@dataclass(frozen=True)
class LineItem:
    """The inputs of one specimen, and their line."""

    line: int
    inputs: dict[str, str]


def read_list(text: str, asked: Mapping[str, Input], name: str = "list") -> list[LineItem]:
    """Return the specimens of a list, one per line; empty lines are skipped.

    If the first line has names of inputs, it is a CSV (comma, semicolon or tab); otherwise each
    line is one specimen. Raises InvalidFileError with every invalid line, and UsageError if the
    procedure has no inputs, or the list is empty or too long.
    """
    lines = [(number, line) for number, line in enumerate(_lines(text), 1) if line.strip()]
    if not asked:
        raise UsageError("the procedure has no inputs, so there is no specimen to give")
    if not lines:
        raise UsageError("the list is empty", hint="write one specimen per line")
    if len(lines) > MOST_LINES:
        message = f"the list has {len(lines)} lines, expected at most {MOST_LINES}"
        raise UsageError(message, hint="add it in parts")
    header, delimiter = _header(lines[0][1], asked)
    if header and len(lines) == 1:
        raise UsageError("the list has a header and no specimen", hint="add one line per specimen")
    problems: list[Problem] = []
    items: list[LineItem] = []
    for number, line in lines[1:] if header else lines:
        try:
            cells = _cells(line, delimiter) if header else [line]
            items.append(LineItem(number, _inputs(cells, header or [_key(asked)], asked)))
        except AnswerError as error:
            problems.append(Problem(error.message, Location(name, number), hint=error.hint))
    if problems:
        raise InvalidFileError(problems)
    return items


def accepted_inputs(given: Mapping[str, str], asked: Mapping[str, Input]) -> dict[str, str]:
    """Return inputs in the form for the record; raise UsageError for an invalid one."""
    found = {}
    for name, text in given.items():
        if name not in asked:
            hint = f"it asks for: {', '.join(asked) or 'nothing'}"
            raise UsageError(f"the procedure has no input '{name[:60]}'", hint=hint)
        try:
            found[name] = asked[name].expected.accept(text)
        except AnswerError as error:
            raise UsageError(f"{name}: {error.message}", hint=error.hint) from error
        if not found[name]:
            raise UsageError(f"{name}: got nothing", hint="leave it out to be asked at the start")
    return found


def _lines(text: str) -> list[str]:
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _key(asked: Mapping[str, Input]) -> str:
    return SPECIMEN if SPECIMEN in asked else next(iter(asked))


def _header(line: str, asked: Mapping[str, Input]) -> tuple[list[str], str]:
    """Return the inputs in the first line, and the separator; none for a specimen."""
    known = {name.casefold(): name for name in asked}
    for delimiter in DELIMITERS:
        cells = [cell.strip().casefold() for cell in line[:LONGEST_LINE].split(delimiter)]
        if cells[0] in known and _key(asked).casefold() in cells:
            unknown = [cell for cell in cells if cell not in known]
            if unknown and len(cells) == 1:
                continue
            if unknown:
                raise UsageError(
                    f"got the column '{unknown[0][:60]}', expected inputs of the procedure",
                    hint=f"it asks for: {', '.join(asked)}",
                )
            return [known[cell] for cell in cells], delimiter
    return [], ""


def _cells(line: str, delimiter: str) -> list[str]:
    if len(line) > LONGEST_LINE:
        raise AnswerError(f"got {len(line)} characters, expected at most {LONGEST_LINE}")
    try:
        return next(csv.reader([line], delimiter=delimiter, strict=True))
    except csv.Error as error:
        raise AnswerError(f"is not a line of CSV: {error}") from error


def _inputs(cells: list[str], names: list[str], asked: Mapping[str, Input]) -> dict[str, str]:
    if len(cells) != len(names):
        count, columns = len(cells), ", ".join(names)
        words = f"got {count} {'cell' if count == 1 else 'cells'}, expected {len(names)}: {columns}"
        raise AnswerError(words)
    found = dict(_accepted(cells, names, asked))
    if not found.get(_key(asked)):
        raise AnswerError(f"has no {_key(asked)}")
    return found


def _accepted(
    cells: list[str], names: list[str], asked: Mapping[str, Input]
) -> Iterator[tuple[str, str]]:
    """Yield each given input; an empty cell is asked for when the run starts."""
    for name, cell in zip(names, cells, strict=True):
        if len(cell) > LONGEST_LINE:
            raise AnswerError(f"got {len(cell)} characters, expected at most {LONGEST_LINE}")
        if cell.strip():
            yield name, asked[name].expected.accept(cell)
