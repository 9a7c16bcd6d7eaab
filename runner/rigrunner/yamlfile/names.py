"""Names in procedures and stations: of roles, inputs and parameters, of channels and drives."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, Field

from rigrunner.api.texts import plain

_NAME = "[A-Za-z][A-Za-z0-9_]*"
_MEMBER = rf"{_NAME}\.{_NAME}"
_IDENTIFIER = "[A-Za-z0-9][A-Za-z0-9._-]*"


def _name(text: str) -> str:
    if not re.fullmatch(_NAME, text):
        raise ValueError(f"'{text[:40]}' is not a name: letters, digits and _, a letter first")
    return text


def _member(text: str) -> str:
    if not re.fullmatch(_MEMBER, text):
        raise ValueError(f"'{text[:40]}' is not of the form role.name, such as tester.torque")
    return text


def _identifier(text: str) -> str:
    if not re.fullmatch(_IDENTIFIER, text):
        raise ValueError(f"'{text[:40]}' is not an id: letters, digits, '.', '_' and '-' alone")
    return text


Name = Annotated[str, AfterValidator(_name), Field(json_schema_extra={"pattern": f"^{_NAME}$"})]
"""The name of a role, an input or a parameter."""

Member = Annotated[
    str,
    AfterValidator(_member),
    Field(
        json_schema_extra={
            "pattern": f"^{_MEMBER}$",
            "patternErrorMessage": "allowed is role.name, such as tester.torque",
        }
    ),
]
"""A channel or drive of a device: `role.name`."""

Identifier = Annotated[
    str, AfterValidator(_identifier), Field(json_schema_extra={"pattern": f"^{_IDENTIFIER}$"})
]
"""An id that also serves in names of files and folders."""

Text = Annotated[str, Field(min_length=1), AfterValidator(plain)]
"""Words for a person."""


def is_name_or_member(text: str) -> bool:
    """Say whether a text is the name of a role, or `role.name`."""
    return bool(re.fullmatch(rf"{_NAME}(?:\.{_NAME})?", text))


def split_member(member: str) -> tuple[str, str]:
    """Return role and name of `role.name`."""
    role, _, name = member.partition(".")
    return role, name
