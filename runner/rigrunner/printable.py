"""Makes texts from elsewhere safe to show: on a terminal, in a log, in XML."""

from __future__ import annotations

import unicodedata

UNPRINTABLE = "\N{REPLACEMENT CHARACTER}"


def printable(text: str) -> str:
    """Return a text of one line or more without characters that control a terminal.

    These are control characters, with which a file could erase the lines about it, and marks that
    reverse the order of letters. Spaces of any width, tabs and ends of lines stay.
    """
    if text.replace("\n", "").replace("\t", "").isprintable():
        return text  # as nearly always: checking each character of a long result is slow
    return "".join(character if _is_shown(character) else UNPRINTABLE for character in text)


def _is_shown(character: str) -> bool:
    return character.isprintable() or character in "\n\t" or unicodedata.category(character) == "Zs"
