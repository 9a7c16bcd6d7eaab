"""Cells of CSV files that do not become formulas in a spreadsheet.

A spreadsheet reads a cell that begins with '=', '+', '-' or '@' as a formula, which may run a
program or send the table elsewhere. A leading apostrophe marks it as text (OWASP, 'CSV Injection').
"""

from __future__ import annotations

import re
from typing import Any

_FORMULA = re.compile(
    r"(^|[\t\n;])(?=[=+\-@\t\N{FULLWIDTH EQUALS SIGN}\N{FULLWIDTH PLUS SIGN}"
    r"\N{FULLWIDTH HYPHEN-MINUS}\N{FULLWIDTH COMMERCIAL AT}])"
)
"""The start of a formula: of the text, or after what may separate cells: a line end, a tab, or a
semicolon where the comma is the decimal mark."""


def cell(value: Any) -> Any:
    """Return a value for a cell: a text that would be a formula gets a leading apostrophe.

    Other values, and texts that are numbers, such as '-0.5', stay as they are. Line ends of texts
    become line feeds.
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
