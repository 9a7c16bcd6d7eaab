"""An instrument behind VISA: readable, settable, and recording if its station defines a stream."""

from __future__ import annotations

import re
from functools import partial
from typing import TYPE_CHECKING

from rigrunner.api import (
    DeviceError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
    Identity,
)
from rigrunner.api.driver import check_patience
from rigrunner_plugins.devices.commanded import CommandedDriver
from rigrunner_plugins.devices.declared import channel_infos, drive_infos, reading_infos
from rigrunner_plugins.devices.text.commands import with_value
from rigrunner_plugins.devices.text.numbers import excerpt
from rigrunner_plugins.devices.text.patterns import fits
from rigrunner_plugins.devices.visa.link import VisaLink

if TYPE_CHECKING:
    from rigrunner.api import DeviceContext
    from rigrunner.api.readings import Reading
    from rigrunner_plugins.devices.text.patterns import Check
    from rigrunner_plugins.devices.visa.settings import VisaChannel, VisaDrive, VisaSettings

_MOST_ERRORS = 20
"""How many errors are taken out of the queue; SCPI instruments keep 2 to 20 or so."""


class Visa(CommandedDriver):
    """An instrument that is queried and set in text."""

    def __init__(self, settings: VisaSettings, context: DeviceContext) -> None:
        super().__init__(context, channel_infos(settings.channels), drive_infos(settings.drives))
        check_patience(settings.timeout, context)
        self._settings = settings
        self.readings = reading_infos(settings.readings)
        self.safe_commands = settings.safe_commands
        self._link = VisaLink(settings, context.folder, context.clock)

    def begin_talk(self, timeout_s: float) -> Identity:
        """Open the connection and identify."""
        self.exchange(f"open {self._settings.resource}", lambda: self._link.open(timeout_s))
        identity = self._identify()
        self._read_errors()  # of earlier users
        return identity

    def set_up(self) -> None:
        """Send the commands for connecting, and make the checks."""
        for command in self._settings.on_connect:
            self.send(command)
        for check in self._settings.verify:
            self.check(check, "the instrument is not set as the station says")

    def shut(self) -> None:
        """Give the connection back."""
        self._link.close()

    def get(self, channel: str) -> float:
        """Ask for the present value of a channel."""
        settings = self._settings.channels[channel]
        return self._number(settings.query, settings)

    def get_reading(self, reading: str) -> Reading:
        """Query a reading."""
        settings = self._settings.readings[reading]
        answer = self.ask(settings.query)
        try:
            return settings.reading_in(answer, f"the answer to '{settings.query}'")
        except DeviceError:
            self._link.drop()  # it may be the answer to something else
            raise

    def put(self, drive: str, value: float) -> None:
        """Send a drive its new set-point."""
        settings = self._settings.drives[drive]
        self.send(with_value(settings.command, settings.from_si(value)))

    def actual(self, drive: str) -> float:
        """Query the actual value of a drive."""
        settings = self._settings.drives[drive]
        return self._number(settings.read_back, settings)

    def send(self, command: str) -> None:
        """Send a command; raise DeviceRejectedError if the instrument reports an error."""
        if self._settings.acknowledge:
            answer = self.ask(command)
            if not fits(self._settings.acknowledge, answer):
                raise DeviceRejectedError(
                    f"the instrument does not accept '{command}': it answers {excerpt(answer)}",
                    hint=f"expected an answer that matches '{self._settings.acknowledge}'",
                )
        else:
            self.exchange(f"send {command}", lambda: self._link.send(command))
        if errors := self._read_errors():
            message = f"the instrument does not accept '{command}': {'; '.join(errors)}"
            if re.match(r"[+-]?[0-9]", errors[0]):
                raise DeviceRejectedError(message)
            self._link.drop()  # no number of an error: the answer may be to something else
            raise DeviceRejectedError(
                message, hint="if it answers commands, state the answer in `acknowledge`"
            )

    def ask(self, query: str) -> str:
        """Return the answer to a query."""
        try:
            return self.exchange(f"query {query}", lambda: self._link.ask(query))
        except DeviceTimeoutError as error:
            self._explain(error)
            raise

    def check(self, check: Check, problem: str) -> None:
        """Raise DeviceRejectedError if the answer to a query is not the good one."""
        answer = self.ask(check.query)
        if not fits(check.good, answer):
            raise DeviceRejectedError(
                f"{problem}: it answers '{check.query}' with {excerpt(answer)}",
                hint=f"expected an answer that matches '{check.good}'",
            )

    def _number(self, query: str, settings: VisaChannel | VisaDrive) -> float:
        answer = self.ask(query)
        try:
            return settings.to_si(settings.number_in(answer, f"the answer to '{query}'"))
        except DeviceError:
            self._link.drop()  # it may be the answer to something else
            raise

    def _identify(self) -> Identity:
        identification, resource = self._settings.identification, self._settings.resource
        simulated = self._settings.simulated
        if identification is None:
            return Identity("unidentified", f"instrument at {resource}", "", simulated=simulated)
        query, expect = identification.query, identification.expect
        return identity_of(self.ask(query), resource, query, expect, simulated=simulated)

    def _read_errors(self) -> list[str]:
        """Empty the error queue and return its errors."""
        queue, errors = self._settings.error_queue, list[str]()
        if queue is None:
            return errors
        ask = partial(self._link.ask, queue.query)
        while len(errors) < _MOST_ERRORS:
            answer = self.exchange(f"query {queue.query}", ask)
            if fits(queue.good, answer):
                break
            errors.append(answer.strip())
        return errors

    def _explain(self, error: DeviceError) -> None:
        """Add the instrument's own errors to that of a query without an answer."""
        try:
            with self.without_setup():
                errors = self._read_errors()
        except DeviceError:
            return  # it answers nothing at all
        if errors:
            error.message += f"; the instrument says: {'; '.join(errors)}"


def identity_of(
    answer: str, resource: str, query: str, expect: str, *, simulated: bool
) -> Identity:
    """Return maker, model, serial and firmware, as the answer to *IDN? has them.

    IEEE 488.2-1992, 10.14.3, wants four fields with commas between them, and 0 for what the
    instrument does not know; an answer of another shape is the model. Raises DeviceNotFoundError
    for an answer that does not fit `expect`.
    """
    if not fits(expect, answer):
        raise DeviceNotFoundError(
            f"at {resource} answers {excerpt(answer)} to '{query}', which does not fit '{expect}'",
            hint="is it the right instrument? in `expect`, .* matches anything",
        )
    fields = [field.strip() for field in answer.strip().split(",", 3)]
    if len(fields) < 4:  # noqa: PLR2004  (the fields of *IDN?)
        return Identity("unknown", answer.strip(), "", simulated=simulated)
    maker, model, serial, firmware = ("" if field == "0" else field for field in fields)
    return Identity(maker, model, serial, firmware, simulated=simulated)
