"""The connection to a device that exists only in the program."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, Protocol

from rigrunner.api import DeviceLostError, DeviceNotFoundError, Identity

if TYPE_CHECKING:
    from rigrunner.api import Clock


class Connectable(Protocol):
    """Settings with the identity of the device."""

    @property
    def seed(self) -> int:
        """Which of its kind it is."""
        ...

    @property
    def simulate(self) -> Literal["ready", "unplugged"]:
        """Whether it answers."""
        ...


class Connection:
    """Open or closed, and since when it is open."""

    def __init__(self, model: str, settings: Connectable, clock: Clock) -> None:
        self._model = model
        self._settings = settings
        self._clock = clock
        self._since_s: float | None = None

    def open(self, timeout_s: float) -> Identity:
        """Return who answered; raise DeviceNotFoundError where the settings unplug it."""
        if self._settings.simulate == "unplugged":
            raise DeviceNotFoundError(
                f"no {self._model} answered within {timeout_s:g} s",
                hint="the station simulates an unplugged device; set 'simulate: ready'",
            )
        self._since_s = self._clock.monotonic_s()
        serial = f"SIM-{self._settings.seed:04d}"
        return Identity("Rigrunner", self._model, serial, simulated=True)

    def close(self) -> None:
        """Release it."""
        self._since_s = None

    def need(self) -> float:
        """Return when it was opened, by the clock; raise DeviceLostError where it is closed."""
        if self._since_s is None:
            raise DeviceLostError(f"the {self._model} is not connected")
        return self._since_s
