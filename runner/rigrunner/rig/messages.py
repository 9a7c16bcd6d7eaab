"""Log messages of drivers, kept until they are recorded as events."""

from __future__ import annotations

from collections import Counter, deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from rigrunner.api.texts import visible

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.devices import DeviceLog

MOST = 1000
"""Limit of messages per device and run, so that one message per reading cannot fill the file."""
Level = Literal["info", "warning", "error"]


@dataclass(frozen=True)
class DeviceMessage:
    """One message of a driver."""

    role: str
    level: Level
    text: str


class DeviceMessages:
    """Collects the messages of all devices of a rig; thread-safe."""

    def __init__(self) -> None:
        self._waiting: deque[DeviceMessage] = deque()
        self._counts = Counter[str]()

    def log_of(self, role: str) -> DeviceLog:
        """Return the log of the driver in a role."""
        return _RoleLog(role, self)

    def take(self, role: str, level: Level, text: str) -> None:
        """Add a message; beyond the limit of a device, drop it."""
        self._counts[role] += 1
        if self._counts[role] < MOST:
            self._waiting.append(DeviceMessage(role, level, visible(text)))
        elif self._counts[role] == MOST:
            more = f"{MOST - 1} messages were logged; further ones are dropped"
            self._waiting.append(DeviceMessage(role, "warning", more))

    def __bool__(self) -> bool:
        """Whether there are messages."""
        return bool(self._waiting)

    def taken(self) -> Iterator[DeviceMessage]:
        """Yield and remove the messages, oldest first."""
        while self._waiting:
            yield self._waiting.popleft()


@dataclass(frozen=True)
class _RoleLog:
    """The DeviceLog of one role."""

    role: str
    messages: DeviceMessages

    def info(self, text: str, *values: object) -> None:
        self._take("info", text, values)

    def warning(self, text: str, *values: object) -> None:
        self._take("warning", text, values)

    def error(self, text: str, *values: object) -> None:
        self._take("error", text, values)

    def _take(self, level: Level, text: str, values: tuple[object, ...]) -> None:
        try:
            message = text % values if values else text
        except Exception:  # noqa: BLE001  (a message must not cost a measurement)
            message = f"{text} {values}"
        self.messages.take(self.role, level, message)
