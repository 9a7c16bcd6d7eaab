"""Texts of others, as they can be shown: on a terminal, in a log, in XML."""

from __future__ import annotations

import unicodedata

UNPRINTABLE = "\N{REPLACEMENT CHARACTER}"


def printable(text: str) -> str:
    """Return a text of one line or more without what would steer a terminal.

    That is control characters, with which a file could remove what was said of it, and marks that
    turn the order of letters. Spaces of any width, tabs and ends of lines stay.
    """
    if text.replace("\n", "").replace("\t", "").isprintable():
        return text  # as nearly all is: to look at each sign of a long result takes its time
    return "".join(each if _is_shown(each) else UNPRINTABLE for each in text)


def _is_shown(sign: str) -> bool:
    return sign.isprintable() or sign in "\n\t" or unicodedata.category(sign) == "Zs"
