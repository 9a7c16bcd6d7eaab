"""An instrument that a class of PyMeasure drives."""

from __future__ import annotations

import warnings
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any, SupportsFloat, TypeVar

import numpy as np

from rigrunner.api import (
    DeviceError,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    Identity,
    MissingPackageError,
    PluginError,
)
from rigrunner.api.driver import check_patience
from rigrunner_plugins.devices.commanded import CommandedDriver, OneAtATime
from rigrunner_plugins.devices.declared import channel_infos, drive_infos
from rigrunner_plugins.devices.pymeasure.binding import (
    check_names,
    instrument_class,
    need_property,
)
from rigrunner_plugins.devices.pymeasure.settings import FAKES
from rigrunner_plugins.devices.text.numbers import OVERLOAD, excerpt
from rigrunner_plugins.devices.visa.device import identity_of
from rigrunner_plugins.devices.visa.errors import visa_errors
from rigrunner_plugins.devices.visa.opening import (
    is_gone,
    library,
    open_error,
    send_at_once,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api import DeviceContext
    from rigrunner_plugins.devices.pymeasure.settings import PyMeasureSettings


_T = TypeVar("_T")
_HINT = "is the instrument switched on, and is it the one for this class?"


def make(settings: PyMeasureSettings, context: DeviceContext) -> PyMeasureDevice:
    """Return the device; raise PluginError for a class, property or method that there is not.

    Where PyMeasure is not installed, as at a desk, that is known only once it is connected.
    """
    with suppress(MissingPackageError):
        check_names(instrument_class(settings.instrument), settings)
    return PyMeasureDevice(settings, context)


class PyMeasureDevice(CommandedDriver):
    """An instrument whose channels and drives are properties of a class of PyMeasure.

    After a failure of the connection the class is made again for what comes next.
    """

    def __init__(self, settings: PyMeasureSettings, context: DeviceContext) -> None:
        super().__init__(context, channel_infos(settings.channels), drive_infos(settings.drives))
        check_patience(settings.timeout, context)
        self.safe_commands = settings.safe_calls
        self._settings = settings
        self._folder = context.folder
        self._one_at_a_time = OneAtATime()
        self._instrument: Any = None
        self._open_s = settings.timeout

    def begin_talk(self, timeout_s: float) -> Identity:
        """Make the instrument's class and identify."""
        self._open_s = timeout_s
        self.exchange(f"open {self._settings.resource}", self._open)
        return self._identify()

    def set_up(self) -> None:
        """Set the properties and call the methods of the station's settings."""
        for name, value in self._settings.setup.items():
            self._set(name, value)
        for name in self._settings.calls:
            self.send(name)

    def shut(self) -> None:
        """Give the connection back."""
        self._drop()

    def get(self, channel: str) -> float:
        """Read the property of a channel."""
        settings = self._settings.channels[channel]
        return settings.to_si(self._get(settings.property, settings.item))

    def put(self, drive: str, value: float) -> None:
        """Set the property of a drive."""
        settings = self._settings.drives[drive]
        self._set(settings.property, settings.from_si(value))

    def actual(self, drive: str) -> float:
        """Read the property of a drive's actual value."""
        settings = self._settings.drives[drive]
        return settings.to_si(self._get(settings.read_back or settings.property))

    def send(self, command: str) -> None:
        """Call a method of the instrument."""

        def call(instrument: Any) -> None:
            getattr(instrument, command)()

        self._exchange(f"call {command}", call)
        self._check_errors(command)

    def _get(self, name: str, item: int | None = None) -> float:
        def get(instrument: Any) -> float:
            owner, attribute = _owner(instrument, name)
            return number_of(getattr(owner, attribute), name, item)

        label = f"{name} {item}" if item else name
        return self._exchange(f"get {label}", get)

    def _set(self, name: str, value: float | str) -> None:
        def put(instrument: Any) -> None:
            owner, attribute = _owner(instrument, name)
            setattr(owner, attribute, value)

        self._exchange(f"set {name} {value}", put)
        self._check_errors(f"{name} = {value}")

    def _check_errors(self, what: str) -> None:
        if not self._settings.check_errors:
            return
        errors = self._exchange(
            "check errors", lambda instrument: [str(error) for error in instrument.check_errors()]
        )
        if errors:
            raise DeviceRejectedError(f"the instrument does not accept {what}: {'; '.join(errors)}")

    def _identify(self) -> Identity:
        *_, maker, name = self._settings.instrument.split(".")
        settings = self._settings
        simulated, expect = settings.simulated, settings.expect
        if not expect:
            return Identity(maker, name, "", simulated=simulated)
        answer = self._exchange("get *IDN?", lambda instrument: str(instrument.ask("*IDN?")))
        return identity_of(answer, settings.resource, "*IDN?", expect, simulated=simulated)

    def _exchange(self, request: str, work: Callable[[Any], _T]) -> _T:
        return self.exchange(request, partial(self._perform, request, work))

    def _perform(self, request: str, work: Callable[[Any], _T]) -> _T:
        """Do something with the instrument; what fails in PyMeasure is the instrument's refusal."""
        timeout_s = self._settings.timeout
        with self._one_at_a_time.alone(timeout_s + self._open_s):
            if self._instrument is None:
                try:
                    self._open()
                except DeviceNotFoundError as error:
                    raise DeviceLostError(error.message, hint=error.hint) from error
            instrument = self._instrument
            connection = getattr(instrument.adapter, "connection", None)
            try:
                with visa_errors(f"no answer to '{request}'", timeout_s, connection, _HINT):
                    return work(instrument)
            except PluginError as error:
                raise DeviceRejectedError(error.message, hint=error.hint) from error
            except DeviceError:
                self._drop()
                raise
            except ValueError as error:  # of a validator, before anything is sent
                raise _rejection(request, error) from error
            except Exception as error:  # whatever a foreign class raises
                self._drop()
                raise _rejection(request, error) from error

    def _open(self) -> None:
        self._drop()
        settings = self._settings
        class_ = instrument_class(settings.instrument)
        check_names(class_, settings)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # those of PyMeasure are for its own developers
                if settings.instrument.startswith(FAKES):
                    self._instrument = class_()  # it is connected to nothing
                else:
                    self._instrument = class_(
                        settings.resource,
                        visa_library=library(settings.backend, self._folder),
                        open_timeout=int(self._open_s * 1000),
                        **settings.connection,
                    )
        except Exception as error:  # whatever a foreign class raises
            raise open_error(settings.resource, error) from error
        connection = getattr(self._instrument.adapter, "connection", None)
        if connection is not None:
            connection.timeout = settings.timeout * 1000
            if is_gone(connection):
                self._drop()
                raise DeviceNotFoundError(f"no answer from {settings.resource}", hint=_HINT)
            send_at_once(connection)

    def _drop(self) -> None:
        instrument, self._instrument = self._instrument, None
        if instrument is not None:
            with suppress(Exception):  # it is given up, whatever state it is in
                instrument.adapter.close()


def _rejection(request: str, error: Exception) -> DeviceRejectedError:
    return DeviceRejectedError(f"PyMeasure failed to {request}: {type(error).__name__}: {error}")


def _owner(instrument: Any, name: str) -> tuple[Any, str]:
    """Return the instrument, or its channel, and the name of the property of that."""
    from pymeasure.instruments import Channel  # noqa: PLC0415  (optional)

    channel, _, attribute = name.rpartition(".")
    owner = getattr(instrument, channel, None) if channel else instrument
    if channel and not isinstance(owner, Channel):
        channels = [key for key, value in vars(instrument).items() if isinstance(value, Channel)]
        raise PluginError(
            f"{type(instrument).__name__} has no channel '{channel}'",
            hint=f"there are: {', '.join(channels) or 'none'}",
        )
    need_property(type(owner), attribute)
    return owner, attribute


def number_of(value: object, name: str, item: int | None = None) -> float:
    """Return a property's value, or one of several, as a number; raise DeviceRejectedError."""
    element: Any = value
    if isinstance(value, (list, tuple, np.ndarray)):
        count = len(value)
        if item is None:
            raise DeviceRejectedError(
                f"the property {name} gives {count} values", hint="select one with `item`, from 1"
            )
        if item > count:
            raise DeviceRejectedError(
                f"the property {name} gives {count} values, not {item} or more"
            )
        element = value[item - 1]
    if not isinstance(element, SupportsFloat):
        raise DeviceRejectedError(
            f"the property {name} gives {excerpt(str(element))}, which is not a number"
        )
    number = float(element)
    if not abs(number) < OVERLOAD:
        raise DeviceRejectedError(
            f"the property {name} gives {number:g}: overload or 'not a number'",
            hint="choose a larger range, or check the wiring",
        )
    return number
