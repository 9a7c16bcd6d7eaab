"""A request as a handler gets it, and the table entry that leads to the handler."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from pydantic import BaseModel


API = "/api/v1"
"""Where every path of the API begins. A change that breaks clients gets another number."""
SHORT = 64 * 1024
"""The most bytes of a body without the text of a file."""


@dataclass(frozen=True)
class ApiRequest:
    """A request and its sender; the body is of the operation's model."""

    body: Any
    query: Mapping[str, str]
    path: Mapping[str, str]
    client: str
    by: str
    """The sender's name in the records."""


@dataclass(frozen=True)
class Operation:
    """One operation of the API."""

    method: Literal["GET", "POST"]
    path: str
    summary: str
    handler: Callable[[Any, ApiRequest], Any]
    """Gets the rig, or the panel if the operation is not of one rig."""
    answer: type[BaseModel] | None
    """None if the answer is a file, whose path the handler returns."""
    body: type[BaseModel] | None = None
    query: Mapping[str, str] = field(default_factory=dict)
    """The name and description of each parameter of the query."""
    of_rig: bool = False
    """Whether it concerns one rig, which the parameter `rig` names."""
    steers: bool = False
    """Whether the client needs control of the rig, or of any rig if it concerns none."""
    status: int = 200
    longest: int = SHORT
    """The most bytes of its body."""
    urgent: bool = False
    """Whether it has its own threads, so that it does not wait for other requests."""
