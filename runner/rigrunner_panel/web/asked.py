"""A request as a handler gets it, and the table entry that leads to the handler."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from pydantic import BaseModel


API = "/api/v1"
"""Where every path of the API begins. What would break a program of others gets another number."""
SHORT = 64 * 1024
"""Bytes that a body may have, but for texts of files."""


@dataclass(frozen=True)
class Asked:
    """What was asked, by whom; the body is of the operation's model."""

    body: Any
    query: Mapping[str, str]
    path: Mapping[str, str]
    client: str
    by: str
    """How who asks is called on record."""


@dataclass(frozen=True)
class Operation:
    """One thing that can be asked of the panel."""

    method: Literal["GET", "POST"]
    path: str
    summary: str
    handler: Callable[[Any, Asked], Any]
    """Gets the rig, or the panel where it is of no rig."""
    answer: type[BaseModel] | None
    """None where the answer is a file, whose path the handler returns."""
    body: type[BaseModel] | None = None
    query: Mapping[str, str] = field(default_factory=dict)
    """The name of each parameter of the query, and what it is."""
    of_rig: bool = False
    """Whether it is asked of one rig, which `rig` names."""
    steers: bool = False
    """Whether only a client may ask that has control of the rig; of any rig where it is of none."""
    status: int = 200
    longest: int = SHORT
    """Bytes that its body may have."""
    urgent: bool = False
    """Whether it waits for no other request: it has threads of its own."""
