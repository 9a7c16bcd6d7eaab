"""Lists of specimens: scanned or pasted lines, and CSV files."""

from __future__ import annotations

import codecs
import csv
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError, Location, Problem, UsageError, did_you_mean
from rigrunner.procedure.answers import AnswerError
from rigrunner.queue.entries import SPECIMEN

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.procedure import Input

_NEARLY = 0.8
"""Similarity of a misspelt name of a column."""
MOST_LINES = 1000
LONGEST_LINE = 2000
DELIMITERS = ("\t", ";", ",")
_SEPARATOR = re.compile("sep=.", re.IGNORECASE)
"""The first line of a CSV that names the separator for spreadsheets."""


@dataclass(frozen=True)
class LineItem:
    """The inputs of one specimen, and their line."""

    line: int
    inputs: dict[str, str]


def read_list(
    text: str, questions: Mapping[str, Input], name: str = "list"
) -> tuple[list[LineItem], list[Problem]]:
    """Return the specimens of a list, one per line, and its invalid lines; empty ones are skipped.

    If the first line has names of inputs, it is a CSV (comma, semicolon or tab); otherwise each
    line is one specimen. Raises UsageError if the procedure has no inputs, or the list is empty,
    too long or a table without names of its columns.
    """
    # Spreadsheets begin a CSV with a byte order mark.
    first, *others = re.split("\r\n|\r|\n", text.removeprefix("\ufeff"))
    all_lines = ["" if _SEPARATOR.fullmatch(first.strip()) else first, *others]
    lines = [(number, line) for number, line in enumerate(all_lines, 1) if line.strip()]
    if not questions:
        raise UsageError("the procedure has no inputs, so there is no specimen to give")
    if not lines:
        raise UsageError("the list is empty", hint="write one specimen per line")
    if len(lines) > MOST_LINES:
        message = f"the list has {len(lines)} lines, expected at most {MOST_LINES}"
        raise UsageError(message, hint="add it in parts")
    header, delimiter = _header(lines[0][1], questions)
    if header and len(lines) == 1:
        raise UsageError("the list has a header and no specimen", hint="add one line per specimen")
    if not header:
        _refuse_table([line for _, line in lines], questions)
    problems: list[Problem] = []
    items: list[LineItem] = []
    for number, line in lines[1:] if header else lines:
        try:
            cells = _cells(line, delimiter) if header else [line]
            items.append(LineItem(number, _inputs(cells, header or [_key(questions)], questions)))
        except AnswerError as error:
            problems.append(Problem(error.message, Location(name, number), hint=error.hint))
    return items, problems


def list_text(content: bytes, name: str = "list") -> str:
    """Return the text of a file of specimens, as spreadsheets write them.

    That is UTF-8, UTF-16 with its mark, or Windows-1252. Raises DataError for what is no text.
    """
    marked = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    for coding in ("utf-16",) if marked else ("utf-8-sig", "cp1252"):
        try:
            text = content.decode(coding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text and not text.startswith("%PDF"):
            return text
    raise DataError(f"{name} is not a text file", hint="save the table as CSV")


def accepted_inputs(answers: Mapping[str, str], questions: Mapping[str, Input]) -> dict[str, str]:
    """Return inputs in the form for the record; raise UsageError for an invalid one."""
    accepted = {}
    for name, text in answers.items():
        if name not in questions:
            hint = f"it asks for: {', '.join(questions) or 'nothing'}"
            raise UsageError(f"the procedure has no input '{name[:60]}'", hint=hint)
        try:
            accepted[name] = questions[name].expected.accept(text)
        except AnswerError as error:
            raise UsageError(f"{name}: {error.message}", hint=error.hint) from error
        if not accepted[name]:
            raise UsageError(f"{name}: got nothing", hint="leave it out to be asked at the start")
    return accepted


def _key(questions: Mapping[str, Input]) -> str:
    return SPECIMEN if SPECIMEN in questions else next(iter(questions))


def _header(line: str, questions: Mapping[str, Input]) -> tuple[list[str], str]:
    """Return the inputs in the first line, and the separator; none for a specimen."""
    input_names = {name.casefold(): name for name in questions}
    for delimiter in DELIMITERS:
        cells = [cell.strip() for cell in line[:LONGEST_LINE].split(delimiter)]
        cells = _without_empty_end(cells, 1)
        names = [input_names.get(cell.casefold(), "") for cell in cells]
        if _key(questions) not in names:
            continue
        if "" in names:
            raise UsageError(
                f"got the column '{cells[names.index('')][:60]}', expected inputs of the procedure",
                hint=f"it asks for: {', '.join(questions)}",
            )
        return names, delimiter
    return [], ""


def _refuse_table(lines: list[str], questions: Mapping[str, Input]) -> None:
    """Raise UsageError if the lines are rows of a table: its columns are not known.

    A serial number may have a comma or a semicolon, so it takes two rows to tell. A first line that
    is nearly the name of the input, without a digit, is a misspelt name of the only column.
    """
    first, key = lines[0].strip().casefold(), _key(questions)
    if not re.search("[0-9]", first) and (hint := did_you_mean(first, [key], cutoff=_NEARLY)):
        raise UsageError(f"got '{lines[0].strip()}' as the first line", hint=hint)
    for delimiter in DELIMITERS:
        counts = {line.count(delimiter) + 1 for line in lines}
        columns = max(counts)
        is_table = len(lines) > 1 and len(counts) == 1
        if columns > 1 and (delimiter == "\t" or is_table):
            message = f"the list has {columns} columns without names"
            hint = f"write a first line with their names, of: {', '.join(questions)}"
            raise UsageError(message, hint=hint)


def _without_empty_end(cells: list[str], least: int) -> list[str]:
    """Return cells without the empty ones behind the last column."""
    while len(cells) > least and not cells[-1].strip():
        cells = cells[:-1]
    return cells


def _cells(line: str, delimiter: str) -> list[str]:
    if len(line) > LONGEST_LINE:
        raise AnswerError(f"got {len(line)} characters, expected at most {LONGEST_LINE}")
    try:
        return next(csv.reader([line], delimiter=delimiter, strict=True))
    except csv.Error as error:
        raise AnswerError(f"is not a line of CSV: {error}") from error


def _inputs(cells: list[str], names: list[str], questions: Mapping[str, Input]) -> dict[str, str]:
    cells = _without_empty_end(cells, len(names))
    if len(cells) != len(names):
        count, columns = len(cells), ", ".join(names)
        words = f"got {count} {'cell' if count == 1 else 'cells'}, expected {len(names)}: {columns}"
        raise AnswerError(words)
    inputs = {}
    for name, cell in zip(names, cells, strict=True):
        if len(cell) > LONGEST_LINE:
            raise AnswerError(f"got {len(cell)} characters, expected at most {LONGEST_LINE}")
        if cell.strip():  # an empty one is asked for when the run starts
            inputs[name] = questions[name].expected.accept(cell)
    if not inputs.get(_key(questions)):
        raise AnswerError(f"has no {_key(questions)}")
    return inputs
