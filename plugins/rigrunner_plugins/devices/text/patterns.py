"""Regular expressions from a station, and checks of an answer by one."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, Field

from rigrunner.api.settings import Settings


def _compilable(text: str) -> str:
    try:
        re.compile(text)
    except re.error as error:
        raise ValueError(f"'{text}' is no regular expression: {error}") from error
    return text


Regex = Annotated[str, AfterValidator(_compilable)]
Command = Annotated[str, Field(min_length=1)]
"""A text that the instrument is sent, without its termination."""


def fits(pattern: str, text: str) -> bool:
    """Say whether the whole text, without the blanks around it, fits the regular expression."""
    return re.fullmatch(pattern, text.strip(), re.DOTALL) is not None


class Check(Settings):
    """A query whose answer has to be good."""

    query: Command
    """What the instrument is asked."""
    good: Regex
    """The regular expression that the whole answer fits if all is well."""


class Identification(Settings):
    """How the instrument says who it is."""

    query: Command = "*IDN?"
    """What it is asked."""
    expect: Regex
    """The regular expression that the whole answer fits; .* stands for anything."""
