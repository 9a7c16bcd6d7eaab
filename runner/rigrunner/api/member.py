"""The name of a channel or a drive of a device: `role.name`, parsed once where text is read."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Self

from pydantic_core import core_schema

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue

NAME = "[A-Za-z][A-Za-z0-9_]*"
"""The pattern of names of roles, channels and drives."""
_MEMBER = rf"{NAME}\.{NAME}"


class Member(str):
    """A channel or a drive of the device in a role.

    It is the text `role.name` and knows its two parts. It compares, hashes, sorts and prints as
    that text, so mappings with members as keys accept plain texts, also stored ones.
    """

    __slots__ = ("name", "role")
    role: str
    name: str

    def __new__(cls, role: str, name: str) -> Self:
        """Return the member of a role."""
        member = super().__new__(cls, f"{role}.{name}")
        member.role, member.name = role, name
        return member

    @classmethod
    def parse(cls, text: str) -> Member:
        """Return the member named by a text; raise ValueError for another form."""
        if isinstance(text, cls):
            return text
        if not re.fullmatch(_MEMBER, text):
            raise ValueError(f"'{text[:40]}' is not of the form role.name, such as tester.torque")
        return cls(*text.split("."))

    def __getnewargs__(self) -> tuple[str, str]:  # type: ignore[override]  # as __new__ takes
        """Return the arguments for copies and pickles."""
        return self.role, self.name

    @classmethod
    def __get_pydantic_core_schema__(
        cls, source: object, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        """Let settings parse members."""
        return core_schema.no_info_after_validator_function(cls.parse, core_schema.str_schema())

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the schema for editors."""
        json_schema: dict[str, Any] = handler(schema)
        json_schema["pattern"] = f"^{_MEMBER}$"
        json_schema["patternErrorMessage"] = "expected role.name, such as tester.torque"
        return json_schema


def channel_of(value: str) -> Member:
    """Return the channel, 'role.name', of a value: itself, or the channel of its statistic.

    That of 'tester.torque.rms' is tester.torque.
    """
    role, name, *_ = value.split(".")
    return Member(role, name)


def role_of(place: Member | str) -> str:
    """Return the role of a member, or the role itself if a whole device is named."""
    return place.role if isinstance(place, Member) else place
