"""Names in procedures and stations: of roles, inputs and parameters, of channels and drives."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, Field

from rigrunner.api.member import NAME
from rigrunner.api.texts import plain

_IDENTIFIER = "[A-Za-z0-9][A-Za-z0-9._-]*"


def _name(text: str) -> str:
    if not re.fullmatch(NAME, text):
        raise ValueError(f"'{text[:40]}' is not a name: letters, digits and _, a letter first")
    return text


def _identifier(text: str) -> str:
    if not re.fullmatch(_IDENTIFIER, text):
        raise ValueError(f"'{text[:40]}' is not an id: letters, digits, '.', '_' and '-' alone")
    return text


Name = Annotated[str, AfterValidator(_name), Field(json_schema_extra={"pattern": f"^{NAME}$"})]
"""The name of a role, an input or a parameter."""

Identifier = Annotated[
    str, AfterValidator(_identifier), Field(json_schema_extra={"pattern": f"^{_IDENTIFIER}$"})
]
"""An id that also serves in names of files and folders."""

Text = Annotated[str, Field(min_length=1), AfterValidator(plain)]
"""Words for a person."""
