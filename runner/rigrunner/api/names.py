"""Types of names in procedures and stations: roles, inputs, parameters, channels and drives."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, Field

from rigrunner.api.member import NAME
from rigrunner.api.texts import plain

_IDENTIFIER = "[A-Za-z0-9][A-Za-z0-9._-]*"


def valid_name(text: str) -> str:
    """Return a name; raise ValueError for any other text."""
    if not re.fullmatch(NAME, text):
        raise ValueError(f"'{text[:40]}' is not a name: letters, digits and _, a letter first")
    return text


def _identifier(text: str) -> str:
    if not re.fullmatch(_IDENTIFIER, text):
        raise ValueError(f"'{text[:40]}' is not an id: letters, digits, '.', '_' and '-' alone")
    return text


Name = Annotated[str, AfterValidator(valid_name), Field(json_schema_extra={"pattern": f"^{NAME}$"})]
"""The name of a role, an input or a parameter."""

Identifier = Annotated[
    str, AfterValidator(_identifier), Field(json_schema_extra={"pattern": f"^{_IDENTIFIER}$"})
]
"""An id that is also used in the names of files and folders."""

Text = Annotated[str, Field(min_length=1), AfterValidator(plain)]
"""A text for a person."""
