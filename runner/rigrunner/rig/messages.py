"""What drivers tell beside their answers, kept until it is put on record."""

from __future__ import annotations

from collections import Counter, deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.devices import DeviceLog

MOST = 1000
"""Messages of one device in a run: one that tells something at each reading must not fill it."""
Level = Literal["info", "warning", "error"]


@dataclass(frozen=True)
class DeviceMessage:
    """One message of a driver."""

    role: str
    level: Level
    text: str


class DeviceMessages:
    """Takes the messages of all devices of a rig, from any thread."""

    def __init__(self) -> None:
        self._waiting: deque[DeviceMessage] = deque()
        self._counts = Counter[str]()

    def log_of(self, role: str) -> DeviceLog:
        """Return what the driver in a role is given."""
        return _RoleLog(role, self)

    def take(self, role: str, level: Level, text: str) -> None:
        """Keep a message; of very many of one device only the first ones."""
        self._counts[role] += 1
        if self._counts[role] < MOST:
            self._waiting.append(DeviceMessage(role, level, text))
        elif self._counts[role] == MOST:
            more = f"{MOST - 1} messages were told; further ones are dropped"
            self._waiting.append(DeviceMessage(role, "warning", more))

    def __bool__(self) -> bool:
        """Whether any message waits."""
        return bool(self._waiting)

    def taken(self) -> Iterator[DeviceMessage]:
        """Yield what waits, in order, and keep it no longer."""
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
            told = text % values if values else text
        except Exception:  # noqa: BLE001  (a message must not cost a measurement)
            told = f"{text} {values}"
        self.messages.take(self.role, level, told)
