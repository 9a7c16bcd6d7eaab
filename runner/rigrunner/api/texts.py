"""Which characters a text may hold that people write for each other: names, titles, answers.

Refused is what no page shows and what makes it show something else: control characters, which
steer a terminal, and marks that turn the order of letters, by which one name passes for another
(Unicode TR 36, 'Bidirectional Text Spoofing'). Tabs and ends of lines stay; so do the joiners that
some scripts need.
"""

from __future__ import annotations

import re
import unicodedata

TURNING = "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"
"""Marks that turn the order of letters, as a class of a regular expression has them."""
_CONTROLS = "\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff"
_REFUSED = re.compile(f"[{_CONTROLS}{TURNING}]")


def refused_character(text: str) -> re.Match[str] | None:
    """Return the first character of a text that it may not hold, and where it stands."""
    return _REFUSED.search(text)


def name_of(character: str) -> str:
    """Return how a character that cannot be shown is called: 'U+202E (right-to-left override)'."""
    name = unicodedata.name(character, "").lower()
    return f"U+{ord(character):04X}{f' ({name})' if name else ''}"


def plain(text: str) -> str:
    """Return a text; raise ValueError with the place of a character that it may not hold."""
    found = refused_character(text)
    if found is None:
        return text
    raise ValueError(
        f"its character {found.start() + 1} is {name_of(found[0])}; expected a text without"
        " control characters and marks that turn the order of letters"
    )
