"""Cells of a CSV file that is opened in a spreadsheet: text stays text.

A spreadsheet takes a cell that begins with '=' and the like for a formula, which may run a program
or send the table away. An apostrophe before it, which spreadsheets know as "this is text", keeps it
from that (OWASP, 'CSV Injection').
"""

from __future__ import annotations

import re
from typing import Any

_FORMULA = re.compile(
    r"(^|[\t\n;])(?=[=+\-@\t\N{FULLWIDTH EQUALS SIGN}\N{FULLWIDTH PLUS SIGN}"
    r"\N{FULLWIDTH HYPHEN-MINUS}\N{FULLWIDTH COMMERCIAL AT}])"
)
"""Where a cell begins: also behind what parts cells where the comma is the decimal mark."""


def cell(value: Any) -> Any:
    """Return a value as it is, but a text that would be a formula with an apostrophe before it.

    A text that is a number, such as '-0.5', is none. Lines end in one way, which every reader of
    CSV knows.
    """
    if not isinstance(value, str) or _is_number(value):
        return value
    return _FORMULA.sub(r"\1'", value.replace("\r\n", "\n").replace("\r", "\n"))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
