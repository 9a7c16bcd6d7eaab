"""Characters allowed in texts for people: names, titles, answers.

Refused are invisible characters and those that change the display: control characters, which
control a terminal, and marks that change the direction of text, with which one name can look like
another (Unicode TR 36, 'Bidirectional Text Spoofing'). Tabs and line ends are allowed; so are the
joiners that some scripts need.
"""

from __future__ import annotations

import re
import unicodedata

TURNING = "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"
"""Marks that change the direction of text, as a class of a regular expression."""
_CONTROLS = "\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff"
_REFUSED = re.compile(f"[{_CONTROLS}{TURNING}]")
_HIDDEN = re.compile(f"[\\r{_CONTROLS}{TURNING}]")


def refused_character(text: str) -> re.Match[str] | None:
    """Return the first refused character of a text and its index."""
    return _REFUSED.search(text)


def visible(text: str) -> str:
    r"""Return a text of a device or plugin in which each refused character is seen: `\x1b`.

    So is a carriage return, with which a line on a terminal is written over.
    """
    return _HIDDEN.sub(lambda match: match[0].encode("unicode_escape").decode("ascii"), text)


def name_of(character: str) -> str:
    """Return the name of an invisible character: 'U+202E (right-to-left override)'."""
    name = unicodedata.name(character, "").lower()
    return f"U+{ord(character):04X}{f' ({name})' if name else ''}"


def clip(text: str, most: int = 40) -> str:
    """Shorten a text for a message to that many characters."""
    return text if len(text) <= most else f"{text[: most - 1]}…"


def plain(text: str) -> str:
    """Return a text; raise ValueError with the place of a refused character."""
    match = refused_character(text)
    if match is None:
        return text
    raise ValueError(
        f"its character {match.start() + 1} is {name_of(match[0])}; expected a text without"
        " control characters and marks of text direction"
    )
