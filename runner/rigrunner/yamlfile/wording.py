"""Describe an error of a field in a technician's words: what was got, what is expected."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import RigrunnerError, did_you_mean
from rigrunner.api.member import NAME
from rigrunner.api.texts import clip

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from pydantic_core import ErrorDetails

_ALLOWED = {
    "string_type": "a text",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "bool_type": "true or false",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a mapping of names to values",
    "model_type": "a mapping of names to values",
    "model_attributes_type": "a mapping of names to values",
    "literal_error": "{expected}",
    "greater_than": "more than {gt}",
    "greater_than_equal": "{ge} or more",
    "less_than": "less than {lt}",
    "less_than_equal": "{le} or less",
    "multiple_of": "a multiple of {multiple_of}",
    "too_short": "{min_length} or more",
    "too_long": "{max_length} or fewer",
    "string_too_short": "a text of {min_length} or more characters",
    "string_too_long": "a text of {max_length} or fewer characters",
    "string_pattern_mismatch": "a text of the form {pattern}",
}
_PATTERN_WORDS = {f"^{NAME}$": "a name: letters, digits and '_', a letter first"}
"""What a text of a frequent pattern is."""
_MARK_HINT = "it states the type of the file, such as 'rigrunner: procedure/2'"
ALLOWED = ", expected "
"""Separates what was got from what is expected."""
_FILE_MARK = re.compile(r"([a-z]+)/[0-9]+")
"""The pattern of the mark that names the kind of a file, such as station/1."""
_LONGEST = 60


def describe(
    details: ErrorDetails, keys: Sequence[str] = (), parents: Sequence[str] = ()
) -> tuple[str, str]:
    """Return message and hint for a pydantic error.

    Where a key is unknown, `keys` are the known ones, and `parents` those that have it.
    """
    kind, loc, got = details["type"], details["loc"], details["input"]
    context = details.get("ctx", {})
    if kind == "missing":
        hint = _MARK_HINT if loc == ("rigrunner",) else ""
        return f"the key '{loc[-1]}' is missing", hint
    if kind == "extra_forbidden":
        key = str(loc[-1])
        hint = key_hint(key, keys)
        if len(parents) == 1:
            hint = f"it is a key of '{parents[0]}'"
        elif got is None and " " in key:
            hint = "put a text with a comma in quotes"
        return f"unknown key '{clip(key, _LONGEST)}'", hint
    if isinstance(error := context.get("error"), RigrunnerError):
        return error.message, error.hint
    if kind not in _ALLOWED:
        message = str(context.get("error", details["msg"]))
        if kind != "value_error":  # pydantic's own words
            message = message[:1].lower() + message[1:]
        return message, str(context.get("hint", ""))
    allowed = _PATTERN_WORDS.get(context.get("pattern", "")) or _ALLOWED[kind].format(**context)
    return f"got {show(got)}{ALLOWED}{allowed}", _scalar_hint(kind, got, context)


def show(value: object) -> str:
    """Return a value as a message shows it: short, with its kind."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f"'{clip(value, _LONGEST)}'"
    if isinstance(value, dict):
        return f"a mapping of {clip(', '.join(map(str, value)), _LONGEST) or 'nothing'}"
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}"
    return clip(str(value), _LONGEST)


def key_hint(key: str, keys: Sequence[str]) -> str:
    """Return the most similar key, and the keys that exist."""
    return f"{did_you_mean(key, keys)} known keys: {', '.join(keys)}".lstrip() if keys else ""


def _scalar_hint(kind: str, got: object, context: Mapping[str, Any]) -> str:
    if kind == "string_type" and isinstance(got, (bool, int, float)):
        return f"put it in quotes: '{show(got)}'"
    if kind == "literal_error" and isinstance(got, str):
        allowed = re.findall("'([^']*)'", str(context["expected"]))
        kinds = [match[1] for text in (got, *allowed) if (match := _FILE_MARK.fullmatch(text))]
        fallback = ""
        if kinds and kinds[1:] == kinds[:1]:
            return "a newer version of the language needs a newer Rigrunner"
        if len(kinds) > 1:
            fallback = f"this is a file of the kind '{kinds[0]}'; '{kinds[1]}' is needed"
        return did_you_mean(got, allowed, fallback)
    return ""
