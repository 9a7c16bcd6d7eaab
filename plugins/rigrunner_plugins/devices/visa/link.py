"""One conversation over VISA, which is begun again after an answer went missing."""

from __future__ import annotations

from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from rigrunner.api import DeviceLostError, DeviceNotFoundError, DeviceRejectedError
from rigrunner_plugins.devices.commanded import OneAtATime
from rigrunner_plugins.devices.text.numbers import excerpt
from rigrunner_plugins.devices.text.termination import decode, termination_name
from rigrunner_plugins.devices.visa.errors import visa_errors
from rigrunner_plugins.devices.visa.opening import close_resource, open_resource

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager
    from pathlib import Path

    from rigrunner.api import Clock
    from rigrunner_plugins.devices.visa.settings import VisaSettings


_NOBODY_S = 1.0
"""How much longer than an answer's time a conversation of another thread is waited for."""

# VISA counts time limits in whole milliseconds; each message waits this one before it is sent.
_UNREAD_MS = 1
_UNREAD_BYTES = 100


class VisaLink:
    """Sends texts to an instrument and returns its answers.

    After an answer that did not come in time, a late one would be taken for that of the next
    query. So the connection is then given back, and opened again before the next message.
    """

    def __init__(self, settings: VisaSettings, folder: Path, clock: Clock) -> None:
        self._settings = settings
        self._folder = folder
        self._clock = clock
        self._one_at_a_time = OneAtATime()
        self._hint = (
            "is the instrument switched on, does it support this message, and does it end its"
            " messages with"
            f" {termination_name(settings.termination)}, as `termination` says?"
        )
        self._resource: Any = None
        self._was_open = False
        self._open_s = settings.timeout

    def open(self, timeout_s: float) -> None:
        """Open the connection; raise DeviceNotFoundError if there is no instrument."""
        with self._alone():
            self._open_s = timeout_s
            self._open()
            self._was_open = True

    def close(self) -> None:
        """Give the connection back, in any state."""
        # Without `_alone`: a thread whose exchange hangs must not keep it open.
        self._was_open = False
        self._drop()

    def drop(self) -> None:
        """Give up a conversation that is out of step; the next message begins a new one."""
        with self._alone():
            self._drop()

    def send(self, command: str) -> None:
        """Send a command that is not answered."""
        with self._talk(f"'{command}' could not be sent", self._settings.timeout) as resource:
            self._write(resource, command)

    def ask(self, query: str, timeout_s: float | None = None) -> str:
        """Send a query and return the answer without its termination."""
        limit_s = timeout_s or self._settings.timeout
        with self._talk(f"no answer to '{query}'", limit_s) as resource:
            self._write(resource, query)
            return self._without_termination(bytes(resource.read_raw()), query)

    def ask_block(self, query: str, timeout_s: float) -> bytes:
        """Send a query and return the bytes of the block that answers it (IEEE 488.2, 8.7.9)."""
        with self._talk(f"no block in answer to '{query}'", timeout_s) as resource:
            self._write(resource, query)
            resource.read_termination = None  # nothing in a block means anything but its data
            try:
                if self._settings.has_messages:
                    return whole_block(bytes(resource.read_raw()), query)
                return self._read_block(resource, query)
            finally:
                resource.read_termination = self._settings.termination

    def _read_block(self, resource: Any, query: str) -> bytes:
        start = resource.read_bytes(2)
        digits = resource.read_bytes(digits_of_length(start, query))
        data: bytes = resource.read_bytes(data_length(digits, query))
        end = resource.read_bytes(len(self._settings.termination))
        if end != self._settings.termination.encode():
            raise DeviceRejectedError(
                f"behind the block that answers '{query}' comes {end!r},"
                f" the station says {termination_name(self._settings.termination)}",
                hint="is `termination` right?",
            )
        return data

    def _write(self, resource: Any, text: str) -> None:
        if unread := self._unread(resource):
            raise DeviceRejectedError(
                f"before '{text}' was sent, the instrument had sent {excerpt(unread)} unasked",
                hint="does it answer commands (see `acknowledge`)? is `termination` right?",
            )
        ending = self._settings.write_termination
        if ending is None:
            ending = self._settings.termination
        self._clock.sleep(self._settings.pause)
        resource.write_raw((text + ending).encode())

    def _unread(self, resource: Any) -> str:
        """Return what has come unasked, or late: it would be taken for the next answer."""
        if self._settings.has_messages:
            # IEEE 488.2 has an instrument discard an unread answer when a new message comes
            # (INTERRUPTED).
            return ""
        from pyvisa.errors import VisaIOError  # noqa: PLC0415  (slow, and optional)

        unread, patience = b"", resource.timeout
        resource.timeout = _UNREAD_MS
        with suppress(VisaIOError):
            while len(unread) < _UNREAD_BYTES:
                unread += resource.read_bytes(1)
        resource.timeout = patience
        return decode(unread)

    def _without_termination(self, raw: bytes, query: str) -> str:
        text, ending = decode(raw), self._settings.termination
        ending_name = termination_name(ending)
        if not text.endswith(ending):
            raise DeviceRejectedError(
                f"the answer to '{query}' is {excerpt(text)}, which does not end with"
                f" {ending_name}",
                hint="is `termination` right?",
            )
        if text[:1] in {"\r", "\n"} and text.strip():
            raise DeviceRejectedError(
                f"the answer to '{query}' is {excerpt(text)}: it begins with the end of another"
                " one",
                hint=f"`termination` is {ending_name}; does the instrument send more than that?",
            )
        return text.removesuffix(ending)

    @contextmanager
    def _talk(self, problem: str, timeout_s: float) -> Iterator[Any]:
        """Yield the open resource; whatever goes wrong ends the conversation."""
        with self._alone():
            if not self._was_open:
                raise DeviceLostError("not connected")
            if self._resource is None:
                self._open()
            try:
                self._resource.timeout = timeout_s * 1000
                with visa_errors(problem, timeout_s, self._resource, self._hint):
                    yield self._resource
            except BaseException:
                self._drop()
                raise

    def _alone(self) -> AbstractContextManager[None]:
        return self._one_at_a_time.alone(self._settings.timeout + self._open_s + _NOBODY_S)

    def _open(self) -> None:
        self._drop()
        try:
            self._resource = open_resource(self._settings, self._folder, self._open_s)
        except DeviceNotFoundError as error:
            # Who has answered before is lost, not absent: the run may connect again.
            if self._was_open:
                raise DeviceLostError(error.message, hint=error.hint) from error
            raise

    def _drop(self) -> None:
        resource, self._resource = self._resource, None
        if resource is not None:
            close_resource(resource)


def digits_of_length(start: bytes, query: str) -> int:
    """Return how many digits the length has, from the first two bytes: #3 says three.

    Raises DeviceRejectedError for what is no block, and for one of indefinite length.
    """
    if start[:1] != b"#" or not start[1:2].isdigit():
        raise DeviceRejectedError(
            f"the answer to '{query}' begins with {start!r}, a block begins with # and a digit",
            hint="is the instrument set to binary data, as `format` says? or is it `ascii`?",
        )
    if start[1:2] == b"0":
        raise DeviceRejectedError(
            f"the answer to '{query}' is a block of indefinite length, whose end is not marked",
            hint="set the instrument to blocks of definite length, or use GPIB, USB or VXI-11",
        )
    return int(start[1:2])


def data_length(digits: bytes, query: str) -> int:
    """Return how many bytes of data follow; raise DeviceRejectedError for what is not a number."""
    if not digits.isdigit():
        raise DeviceRejectedError(
            f"the block that answers '{query}' says {digits!r} where its length should be"
        )
    return int(digits)


def whole_block(message: bytes, query: str) -> bytes:
    """Return the data of a message that is a block; raise DeviceRejectedError.

    One of indefinite length ends with a line feed and the end of the message.
    """
    if message[:2] == b"#0" and message.endswith(b"\n"):
        return message[2:-1]
    begin = 2 + digits_of_length(message[:2], query)
    length = data_length(message[2:begin], query)
    data, rest = message[begin : begin + length], message[begin + length :]
    if len(data) < length or rest.strip(b"\r\n"):
        raise DeviceRejectedError(
            f"the block that answers '{query}' has {len(message) - begin} bytes of data,"
            f" it says {length}"
        )
    return data
