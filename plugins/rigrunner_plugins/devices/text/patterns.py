"""Regular expressions from a station, and checks of an answer by one."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, Field, WithJsonSchema

from rigrunner.api import Settings


def _compilable(text: str) -> str:
    try:
        re.compile(text)
    except re.error as error:
        raise ValueError(f"'{text}' is not a regular expression: {error}") from error
    return text


def shaped(pattern: str, allowed: str) -> tuple[AfterValidator, WithJsonSchema]:
    """Return the annotations of a text that must match a pattern, and the words for the error.

    The pattern is for JSON Schema too: nothing that ECMA 262 does not know.
    """

    def check(text: str) -> str:
        if re.fullmatch(pattern, text) is None:
            raise ValueError(f"got '{text}', expected {allowed}")
        return text

    schema = {
        "type": "string",
        "pattern": f"^(?:{pattern})$",
        "errorMessage": f"expected {allowed}",
    }
    return AfterValidator(check), WithJsonSchema(schema)


Regex = Annotated[str, AfterValidator(_compilable)]
Command = Annotated[str, Field(min_length=1)]
"""A text to send, without its terminator."""


def fits(pattern: str, text: str) -> bool:
    """Return whether the whole text, without the blanks around it, fits the regular expression."""
    return re.fullmatch(pattern, text.strip(), re.DOTALL) is not None


class Check(Settings):
    """A query and its good answer."""

    query: Command
    """The query."""
    good: Regex
    """Regular expression for the whole good answer."""


class Identification(Settings):
    """How the instrument is identified."""

    query: Command = "*IDN?"
    """The query."""
    expect: Regex
    """Regular expression for the whole answer; .* matches anything."""
