"""Sends messages from a thread of its own: neither the run nor other listeners wait for it."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from typing import TYPE_CHECKING

from rigrunner_plugins.listeners.messages import Rules

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rigrunner.api import Event
    from rigrunner_plugins.listeners.messages import Message
    from rigrunner_plugins.listeners.settings import RuleSettings

MOST_WAITING = 100
"""Messages that wait for a receiver; with more the oldest are dropped."""
FIRST_PAUSE_S = 1.0
"""Between the first two tries of a message; each pause is twice the one before."""
LONGEST_PAUSE_S = 30.0
LAST_WORDS_S = 4.0
"""How long the remaining messages are tried after the run."""
_log = logging.getLogger("rigrunner.listeners")


class DeliveryError(Exception):
    """A receiver did not take a message; the text has nothing secret."""

    def __init__(self, why: str, *, again: bool = True) -> None:
        """`again`: whether another try may help."""
        super().__init__(why)
        self.again = again


class Notifier:
    """An event sink that reports what its rules find. `deliver` sends one message, or raises.

    Messages that are not delivered are counted, and logged by the program: in the run's record
    they would go onto certificates.
    """

    def __init__(
        self, name: str, settings: RuleSettings, deliver: Callable[[Message], None]
    ) -> None:
        self.__name__ = name
        self.lost = 0
        """Messages that no receiver got."""
        self._settings = settings
        self._deliver = deliver
        self._rules = Rules(settings)
        self._changed = threading.Condition()
        self._waiting: deque[Message] = deque()
        self._later: tuple[float, Message] | None = None
        self._works = False
        self._over_s: float | None = None
        """When the last try must begin, by the monotonic clock; None while the run lasts."""

    def __call__(self, event: Event) -> None:
        """Take an event; return at once."""
        self._post(self._rules.take(event))

    def close(self) -> None:
        """Send the remaining messages, for LAST_WORDS_S at most; log how many are lost."""
        self._post(self._rules.last())
        with self._changed:
            self._over_s, self._later = time.monotonic() + LAST_WORDS_S, None
            self._changed.notify_all()
            self._changed.wait_for(lambda: not self._works, LAST_WORDS_S)
            left = len(self._waiting) + self._works
            self._waiting.clear()
            self.lost += left
        if self.lost:
            _log.warning("%s: %d messages were not delivered", self.__name__, self.lost)

    def _post(self, messages: Iterable[Message]) -> None:
        with self._changed:
            before = self._later
            for message in messages:
                if len(self._waiting) >= MOST_WAITING:
                    self._waiting.popleft()
                    self.lost += 1
                self._waiting.append(message)
            pending = self._rules.waiting
            if pending is None:
                self._later = None
            elif before is None or before[1] is not pending:
                self._later = time.monotonic() + self._settings.wait, pending
            if (self._waiting or self._later) and not self._works:
                self._works = True
                work = threading.Thread(target=self._work, name=f"to {self.__name__}", daemon=True)
                work.start()
            self._changed.notify_all()

    def _work(self) -> None:
        while (message := self._next()) is not None:
            self._send(message)

    def _next(self) -> Message | None:
        """Return the next message once it is due; None, and end, where there is none."""
        with self._changed:
            while True:
                if self._waiting:
                    return self._waiting.popleft()
                if self._later is None:
                    self._works = False
                    self._changed.notify_all()
                    return None
                due_s, message = self._later
                if due_s <= time.monotonic():
                    self._later = None
                    self._rules.waiting = None
                    return message
                self._changed.wait(due_s - time.monotonic())

    def _send(self, message: Message) -> None:
        for number in range(self._settings.attempts):
            try:
                self._deliver(message)
            except DeliveryError as error:
                reason, again = str(error), error.again
            except OSError as error:  # its text may hold an address with a token
                reason, again = error.strerror or type(error).__name__, True
            except Exception as error:  # noqa: BLE001  (of a library: the next message may pass)
                reason, again = type(error).__name__, False
            else:
                return
            if not again or not self._may_again(min(FIRST_PAUSE_S * 2**number, LONGEST_PAUSE_S)):
                break
        with self._changed:
            self.lost += 1
        _log.warning("%s: '%s' was not delivered: %s", self.__name__, message.kind, reason)

    def _may_again(self, pause_s: float) -> bool:
        """Wait before the next try, FIRST_PAUSE_S at most once the run is over."""
        with self._changed:
            self._changed.wait_for(lambda: self._over_s is not None, pause_s)
            if self._over_s is None:
                return True
        next_s = time.monotonic() + min(pause_s, FIRST_PAUSE_S)
        if next_s >= self._over_s:
            return False
        time.sleep(max(0.0, next_s - time.monotonic()))
        return True
